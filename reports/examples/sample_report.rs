//! Writes a made-up result in every format into a folder: `cargo run -p reports --example sample_report -- DIR`.

use std::path::PathBuf;

mod sample;

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("."), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let results = sample::with_responses();
    for format in reports::FORMATS {
        std::fs::write(folder.join(format.file), (format.render)(&results))?;
    }
    Ok(())
}
