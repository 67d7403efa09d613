use crate::analysis::periodic::*;

fn column(text: &str, c: usize) -> Vec<f64> {
    text.lines().skip(1).map(|l| l.split(',').nth(c).expect("c").parse().expect("n")).collect()
}

#[test]
fn full_record() {
    let d = "/work/shared/data/fditools_motorbench/";
    let a = std::fs::read_to_string(format!("{d}multisine_a.csv")).expect("a");
    let s = std::fs::read_to_string(format!("{d}multisine_a_speed.csv")).expect("s");
    let (r, i, x, v) = (column(&a, 1), column(&a, 2), column(&a, 3), column(&s, 1));
    let w = Windows { sample_rate_hz: 2500.0, length: 2500, starts: (1..20).map(|k| k * 2500).collect() };
    let hz: Vec<f64> = (11..=250).map(f64::from).collect();
    let ch = [("i", &i), ("x", &x), ("v", &v)].map(|(name, s)| Channel { name, samples: s });
    let z = spectra(&w, &hz, &ch, &[]).expect("record");
    let t = transfer(
        &Windows { starts: (1..19).map(|k| k * 2500 + 731).collect(), ..w.clone() },
        &hz,
        &r,
        &ch,
        &[],
    )
    .expect("t");
    for (z, what) in [(&z, "spectra"), (&t, "transfer, odd starts")] {
        for (c, n, name) in [(1, 1, "angle"), (2, 0, "speed")] {
            let f = times_jw(&errors_in_variables(&hz, &z[0], &z[c]).expect("eiv"), n).expect("jw");
            let mut q: Vec<f64> = f.iter().map(|l| l.variance.sqrt() / l.value.norm()).collect();
            q.sort_by(f64::total_cmp);
            eprintln!("{what} {name} median sd/|G| {:.5}", q[120]);
            for k in [11, 25, 53, 77, 100, 200] {
                let l = f[k - 11];
                eprintln!(
                    "  {k} {:.5} {:.2} sd {:.3e} coh {:?}",
                    l.value.norm(),
                    l.phase_rad().to_degrees(),
                    l.variance.sqrt(),
                    l.coherence
                );
            }
        }
    }
    let f = errors_in_variables(&hz, &vec![vec![C64::new(1.0, 0.0); 240]; 18], &t[0]).expect("eiv");
    for k in [11, 131, 250] {
        eprintln!("  i/r {k} {:.4} {:.2}", f[k - 11].value.norm(), f[k - 11].phase_rad().to_degrees());
    }
}
use crate::analysis::frf::C64;
