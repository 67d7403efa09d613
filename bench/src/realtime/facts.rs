//! What a machine says of itself that matters for ticks on time.

use std::path::Path;

use serde::Serialize;

use super::processors::{list_text, listed};

/// What was read; `None` and empty lists where the machine says nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Facts {
    /// Release of the kernel.
    pub kernel: Option<String>,
    /// Model of preemption that the kernel was built with: `PREEMPT_RT`, `PREEMPT_DYNAMIC`, …
    pub preemption: Option<String>,
    /// Whether the kernel calls itself a real-time kernel.
    pub is_realtime: bool,
    /// Whether it runs under a hypervisor, which may take the processor away at any time.
    pub is_virtual_machine: bool,
    /// Processors that are on line.
    pub online: Vec<usize>,
    /// Processors that the scheduler leaves alone (`isolcpus`).
    pub isolated: Vec<usize>,
    /// Processors without a periodic interrupt while they run one thread (`nohz_full`).
    pub without_tick: Vec<usize>,
    /// What the kernel's clock is made of.
    pub clocksource: Option<String>,
    /// Governors of the processors' frequencies, each once.
    pub governors: Vec<String>,
    /// Longest time that a processor needs to wake from an idle state that is enabled, µs.
    pub wakes_within_us: Option<u32>,
    /// Of each second, µs that threads with real-time priority may take; negative without a limit.
    pub rt_runtime_us: Option<i64>,
    /// The network interface that was asked for.
    pub interface: Option<Interface>,
}

/// The interrupts of a network interface.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Interface {
    /// Name.
    pub name: String,
    /// Whether there is one of this name.
    pub exists: bool,
    /// Its interrupts with the processors that handle them, as the kernel lists them.
    pub interrupts: Vec<(u32, String)>,
}

impl Facts {
    /// Reads them below `root`, which is `/` but for tests.
    pub fn read(root: &Path, interface: Option<&str>) -> Self {
        let file = |path: &str| text(root, path);
        let version = file("proc/version").unwrap_or_default();
        let cpuinfo = file("proc/cpuinfo").unwrap_or_default();
        let mut flags = cpuinfo.lines().filter(|line| line.starts_with("flags"));
        let list = |path: &str| listed(&file(path).unwrap_or_default());
        let online = list("sys/devices/system/cpu/online");
        let preemption = version.split_whitespace().find(|word| word.starts_with("PREEMPT"));
        let is_realtime =
            file("sys/kernel/realtime").as_deref() == Some("1") || preemption == Some("PREEMPT_RT");
        Self {
            kernel: version.split_whitespace().nth(2).map(str::to_owned),
            preemption: preemption.map(str::to_owned),
            is_realtime,
            is_virtual_machine: flags.any(|line| line.split_whitespace().any(|flag| flag == "hypervisor")),
            isolated: isolated(root),
            without_tick: list("sys/devices/system/cpu/nohz_full"),
            clocksource: file("sys/devices/system/clocksource/clocksource0/current_clocksource"),
            governors: governors(root, &online),
            wakes_within_us: wakes_within_us(root, &online),
            rt_runtime_us: file("proc/sys/kernel/sched_rt_runtime_us").and_then(|text| text.parse().ok()),
            interface: interface.map(|name| Interface::read(root, name)),
            online,
        }
    }
}

impl Interface {
    fn read(root: &Path, name: &str) -> Self {
        let exists = root.join("sys/class/net").join(name).exists();
        // Message-signalled interrupts of the device, and lines that bear the name of the interface.
        let of_device = std::fs::read_dir(root.join(format!("sys/class/net/{name}/device/msi_irqs")));
        let numbers = of_device.into_iter().flatten().flatten();
        let mut interrupts: Vec<u32> =
            numbers.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).collect();
        let lines = text(root, "proc/interrupts").unwrap_or_default();
        interrupts.extend(lines.lines().filter_map(|line| {
            let (number, rest) = line.trim().split_once(':')?;
            let own = rest.split([' ', '-', '@', ',']).any(|word| word == name);
            own.then(|| number.parse::<u32>().ok()).flatten()
        }));
        interrupts.sort_unstable();
        interrupts.dedup();
        let handled = |number: u32| {
            let list = ["effective_affinity_list", "smp_affinity_list"];
            let read =
                |name| text(root, &format!("proc/irq/{number}/{name}")).filter(|text| !text.is_empty());
            list.into_iter().find_map(read).map(|list| (number, list))
        };
        let interrupts = interrupts.into_iter().filter_map(handled).collect();
        Self { name: name.to_owned(), exists, interrupts }
    }

    /// Numbers of interrupts that this processor handles.
    pub fn handled_by(&self, processor: usize) -> Vec<u32> {
        let here = |(number, list): &(u32, String)| listed(list).contains(&processor).then_some(*number);
        self.interrupts.iter().filter_map(here).collect()
    }
}

/// Processors as the kernel lists them, or `none`.
pub(crate) fn processors_text(processors: &[usize]) -> String {
    if processors.is_empty() { "none".to_owned() } else { list_text(processors) }
}

/// Processors below `root` that the scheduler leaves alone.
pub(super) fn isolated(root: &Path) -> Vec<usize> {
    listed(&text(root, "sys/devices/system/cpu/isolated").unwrap_or_default())
}

fn text(root: &Path, path: &str) -> Option<String> {
    std::fs::read_to_string(root.join(path)).ok().map(|text| text.trim().to_owned())
}

fn governors(root: &Path, online: &[usize]) -> Vec<String> {
    let governor = |n: &usize| text(root, &format!("sys/devices/system/cpu/cpu{n}/cpufreq/scaling_governor"));
    let mut all: Vec<String> = online.iter().filter_map(governor).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn wakes_within_us(root: &Path, online: &[usize]) -> Option<u32> {
    let of_processor = |n: &usize| {
        let states = std::fs::read_dir(root.join(format!("sys/devices/system/cpu/cpu{n}/cpuidle")));
        let latency_us = |state: std::fs::DirEntry| -> Option<u32> {
            let number = |name| text(&state.path(), name)?.parse::<u32>().ok();
            number("latency").filter(|_| number("disable") != Some(1))
        };
        states.into_iter().flatten().flatten().filter_map(latency_us).max()
    };
    online.iter().filter_map(of_processor).max()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().expect("below the folder")).expect("writable");
            std::fs::write(path, text).expect("writable");
        }
        folder
    }

    #[test]
    fn a_machine_that_says_nothing_is_no_mistake() {
        let folder = machine(&[]);
        assert_eq!(Facts::read(folder.path(), None), Facts::default());
        let interface = Facts::read(folder.path(), Some("eth9")).interface.expect("asked for");
        assert!(!interface.exists && interface.interrupts.is_empty());
    }

    #[test]
    fn a_prepared_machine_is_read_with_the_interrupts_of_its_interface() {
        let folder = machine(&[
            ("proc/version", "Linux version 6.12.8-rt (x@y) (gcc) #1 SMP PREEMPT_RT Mon Jan 5 2026\n"),
            ("proc/cpuinfo", "processor : 0\nflags : fpu tsc\n"),
            ("sys/kernel/realtime", "1\n"),
            ("sys/devices/system/cpu/online", "0-3\n"),
            ("sys/devices/system/cpu/isolated", "3\n"),
            ("sys/devices/system/cpu/nohz_full", "3\n"),
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"),
            ("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/cpu/cpu3/cpuidle/state0/latency", "2\n"),
            ("sys/devices/system/cpu/cpu3/cpuidle/state1/latency", "133\n"),
            ("sys/devices/system/cpu/cpu3/cpuidle/state2/latency", "1034\n"),
            ("sys/devices/system/cpu/cpu3/cpuidle/state2/disable", "1\n"),
            ("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n"),
            ("proc/sys/kernel/sched_rt_runtime_us", "950000\n"),
            ("proc/interrupts", "  CPU0\n 44:  12 PCI-MSI enp3s0-TxRx-0\n 45: 1 PCI-MSI enp30s0-TxRx-0\n"),
            ("proc/irq/44/smp_affinity_list", "0-3\n"),
            ("proc/irq/44/effective_affinity_list", "3\n"),
            ("proc/irq/45/smp_affinity_list", "0-3\n"),
            ("proc/irq/131/smp_affinity_list", "2\n"),
            ("sys/class/net/enp3s0/device/msi_irqs/131", "msi\n"),
        ]);
        let facts = Facts::read(folder.path(), Some("enp3s0"));
        assert!(facts.is_realtime && !facts.is_virtual_machine);
        assert_eq!(facts.kernel.as_deref(), Some("6.12.8-rt"));
        assert_eq!((&facts.isolated, &facts.without_tick), (&vec![3], &vec![3]));
        assert_eq!(facts.governors, ["performance", "powersave"]);
        assert_eq!(facts.wakes_within_us, Some(133), "a disabled state does not count");
        let interface = facts.interface.expect("asked for");
        assert_eq!(interface.interrupts, [(44, "3".to_owned()), (131, "2".to_owned())]);
        assert_eq!(interface.handled_by(3), [44]);
    }
}
