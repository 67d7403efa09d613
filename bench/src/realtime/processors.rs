//! Which processor a ticking thread takes.

use rustix::thread::{CpuSet, sched_getaffinity};

/// Processors of a list of the kernel, e.g. `2-3,7`; what is no list has none.
pub(super) fn listed(text: &str) -> Vec<usize> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let number = |text: &str| text.trim().parse::<usize>().ok().filter(|&n| n < CpuSet::MAX_CPU);
        number(first).zip(number(last)).map(|(first, last)| first..=last)
    };
    text.trim().split(',').filter_map(range).flatten().collect()
}

/// Processors as the kernel lists them.
pub(super) fn list_text(processors: &[usize]) -> String {
    let mut parts: Vec<(usize, usize)> = Vec::new();
    for &processor in processors {
        match parts.last_mut() {
            Some((_, last)) if *last + 1 == processor => *last = processor,
            _ => parts.push((processor, processor)),
        }
    }
    let part = |(first, last): (usize, usize)| match first == last {
        true => first.to_string(),
        false => format!("{first}-{last}"),
    };
    parts.into_iter().map(part).collect::<Vec<_>>().join(",")
}

/// Processors that the calling thread may run on.
pub(super) fn allowed() -> Vec<usize> {
    sched_getaffinity(None)
        .map(|set| (0..CpuSet::MAX_CPU).filter(|&processor| set.is_set(processor)).collect())
        .unwrap_or_default()
}

/// The processor to take: the last of the isolated ones, else the last of those allowed where there is another one for
/// everything else. Processor 0 has most of the kernel's own work.
pub(super) fn choice(isolated: &[usize], allowed: &[usize]) -> Option<usize> {
    isolated.last().or(allowed.last().filter(|_| allowed.len() > 1)).copied()
}

/// A set of one.
pub(super) fn only(processor: usize) -> CpuSet {
    let mut set = CpuSet::new();
    set.set(processor);
    set
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_the_kernel_are_read_and_written() {
        for (text, processors) in [("", vec![]), ("3", vec![3]), ("0-2,5,7-8", vec![0, 1, 2, 5, 7, 8])] {
            assert_eq!(listed(&format!("{text}\n")), processors);
            assert_eq!(list_text(&processors), text);
        }
        assert_eq!(listed("no list"), [0; 0]);
        assert_eq!(listed("999999999"), [0; 0], "no such processor");
    }

    #[test]
    fn an_isolated_processor_is_taken_even_where_the_process_may_not_run_yet() {
        assert_eq!(choice(&[2, 3], &[0, 1]), Some(3));
        assert_eq!(choice(&[], &[0, 1, 2]), Some(2));
        assert_eq!(choice(&[], &[0]), None, "everything else needs it");
    }
}
