//! Prints the calibration tables of the simulated polygons, as the driver `polygons` of a rig file wants them.

use std::f64::consts::TAU;

use sim_devices::reference::AngleReference;
use sim_devices::rig::SeedAddress;
use sim_devices::unit::InstrumentsSettings;

fn main() {
    // The polygons do not depend on seed, procedure or point.
    let address = SeedAddress { seed: 0, procedure: String::new(), point: String::new() };
    for (axis, key) in [("az", "azimuth-faces"), ("el", "elevation-faces")] {
        let faces = AngleReference::new(&InstrumentsSettings::default(), &address, axis).faces_rad();
        let count = faces.len() as f64;
        let off = faces.iter().enumerate().map(|(face, place)| {
            let nominal = TAU * face as f64 / count;
            let off_rad = place - nominal;
            format!("\"{:.1} urad\"", 1e6 * (off_rad - TAU * (off_rad / TAU).round()))
        });
        let off: Vec<String> = off.collect();
        let lines: Vec<String> = off.chunks(9).map(|row| format!("    {},", row.join(", "))).collect();
        #[allow(clippy::print_stdout, reason = "an example prints what it is for")]
        {
            println!("{key} = [\n{}\n]", lines.join("\n"));
        }
    }
}
