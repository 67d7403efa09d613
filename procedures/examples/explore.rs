#![allow(warnings)]
#[path = "recovery_breakaway/plant.rs"]
mod plant;
use plant::*;
use procedures::analysis::{breakaway::peak, effort::Effort, multisine::*, presliding::RampFit};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
fn gauss(r: &mut ChaCha8Rng) -> f64 {
    let u = ((r.next_u32() as f64) + 0.5) / 4294967296.0;
    let v = (r.next_u32() as f64) / 4294967296.0;
    (-2.0 * u.ln()).sqrt() * (6.283185307179586 * v).cos()
}
fn ramp(
    p: &Plant,
    kt: f64,
    rate: f64,
    dwell: f64,
    noise: f64,
    quant: bool,
) -> (Vec<f64>, Vec<f64>, Vec<f64>, f64, f64) {
    let mut p = *p;
    p.cogging[0] = 0.0;
    p.unbalance = 0.0;
    p.spring[0] = 0.0;
    let mut s = State { theta: 0.5, omega: 0.0, z: p.z_ss() * 0.9, age: 0.3 };
    let sub = 5;
    let dt = 2.5e-4 / sub as f64;
    for _ in 0..(dwell / dt) as usize {
        p.step(&mut s, 0.0, dt);
    }
    let q = std::f64::consts::TAU / 67108864.0;
    let (mut t, mut x, mut tq) = (vec![], vec![], vec![]);
    let x0 = s.theta;
    let mut k = 0;
    let mut r = ChaCha8Rng::seed_from_u64(5);
    let pre = (0.5 / 2.5e-4) as i64;
    let mut best = 0.0f64;
    for i in -pre.. {
        let time = i as f64 * 2.5e-4;
        let tor = (rate * kt * time).max(0.0);
        t.push(time);
        x.push(if quant { (s.theta / q).floor() * q } else { s.theta });
        tq.push(tor + noise * gauss(&mut r));
        for _ in 0..sub {
            let f = p.step(&mut s, tor, dt);
            let u = (s.theta - x0) / p.z_ss();
            if u >= 3.0 && u <= 8.0 {
                best = best.max(f);
            }
        }
        if s.theta - x0 > 10.0 * p.z_ss() {
            break;
        }
    }
    (t, x, tq, x0, best)
}
fn main() {
    for (name, p, kt) in [("az", AZIMUTH, 60.0), ("el", ELEVATION, 52.0)] {
        for rate in [0.01, 0.1, 0.3, 1.0, 3.0] {
            for dwell in [1.0, 100.0] {
                for noise in [0.0, 0.01 * p.coulomb] {
                    let (t, x, tq, x0, best) = ramp(&p, kt, rate, dwell, noise, noise > 0.0);
                    let e = Effort::new(&t, &x, &tq, p.inertia).unwrap();
                    let d: Vec<f64> = e.position_rad.iter().map(|v| v - x0).collect();
                    let fit = RampFit::new(&e.time_s, &d, &e.effort_nm);
                    if let Some(f) = &fit {
                        print!(
                            "{name} {rate} A/s dwell {dwell} noise {noise:.2}: s0 {:+.3}% u {:.3}% Tinf {:.3} u {:.3} zss {:+.2}% c {:.0} noise {:.4} dof {} ",
                            (f.sigma0 / p.sigma0 - 1.0) * 100.0,
                            f.sigma0_u / p.sigma0 * 100.0,
                            f.plateau_nm,
                            f.plateau_u_nm,
                            (f.z_ss_rad() / p.z_ss() - 1.0) * 100.0,
                            f.damping,
                            f.noise_nm,
                            f.dof
                        );
                    } else {
                        print!("{name} {rate} no fit ");
                    }
                    let pk = peak(&d, &e.effort_nm, p.z_ss());
                    match pk {
                        Ok(k) => println!(
                            "| peak {:.3} u {:.3} truth {best:.3} at {:.2} dlnz {:.2}",
                            k.torque_nm,
                            k.u_nm,
                            k.at_rad / p.z_ss(),
                            k.per_ln_z_ss_nm
                        ),
                        Err(e) => println!("{e}"),
                    }
                }
            }
        }
    }
    // multisine
    for (name, p0) in [("az", AZIMUTH), ("el", ELEVATION)] {
        for level in [0.1, 0.05] {
            for (last, period) in [(100, 10.0), (50, 5.0)] {
                let mut p = p0;
                p.cogging[0] = 0.0;
                p.unbalance = 0.0;
                p.spring[0] = 0.0;
                let des = Design::log_spaced(last, 14);
                let amp = level * p.static_friction / des.peak_ratio;
                let mut s = State { theta: 0.5, omega: 0.0, z: p.z_ss() * 0.9, age: 0.3 };
                let sub = 5;
                let dt = 2.5e-4 / sub as f64;
                for _ in 0..40000 {
                    p.step(&mut s, 0.0, dt);
                }
                let x0 = s.theta;
                let q = std::f64::consts::TAU / 67108864.0;
                let mut r = ChaCha8Rng::seed_from_u64(7);
                let (mut x, mut tq) = (vec![], vec![]);
                let n = (5.0 * period / 2.5e-4) as usize;
                for i in 0..n {
                    let t = i as f64 * 2.5e-4;
                    let fade = (t / period).min(1.0);
                    let w: f64 = des
                        .orders
                        .iter()
                        .zip(&des.phases_rad)
                        .map(|(&k, ph)| (6.283185307179586 * k as f64 * t / period + ph).cos())
                        .sum();
                    let tor = fade * amp * w;
                    x.push((s.theta / q).floor() * q - x0);
                    tq.push(tor + 0.01 * p.coulomb * gauss(&mut r));
                    for _ in 0..sub {
                        p.step(&mut s, tor, dt);
                    }
                }
                let b = 20;
                let xb = procedures::analysis::effort::block_means(&x, b);
                let tb = procedures::analysis::effort::block_means(&tq, b);
                let rec = Record {
                    x_rad: &xb,
                    torque_nm: &tb,
                    period_blocks: (period / 2.5e-4) as usize / b,
                    period_s: period,
                    orders: &des.orders,
                    inertia: p.inertia,
                    start_nm: 0.0,
                };
                let f = Presliding::new(&rec);
                if let Some(f) = f {
                    let c = p.sigma1 + p.viscous;
                    println!(
                        "{name} level {level} period {period}: s0 {:+.3}% u {:.3}% c {:+.3}% u {:.3}% zss {:+.1}% chi2 {:.2} delay {:.1} us xmax {:.3} zss",
                        (f.sigma0 / p.sigma0 - 1.0) * 100.0,
                        f.sigma0_u / p.sigma0 * 100.0,
                        (f.damping / c - 1.0) * 100.0,
                        f.damping_u / c * 100.0,
                        (f.z_ss_rad / p.z_ss() - 1.0) * 100.0,
                        f.misfit_ratio,
                        f.delay_s * 1e6,
                        x.iter().map(|v| v.abs()).fold(0.0, f64::max) / p.z_ss()
                    );
                } else {
                    println!("{name} none");
                }
            }
        }
    }
}
