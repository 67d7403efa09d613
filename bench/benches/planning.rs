//! `check` and `plan` of the shipped campaigns: reading, parsing and planning every file.

use bench::files::rig::read_rig;
use bench::files::shipped::{self, Folder};
use bench::plan::{Wanted, plan};

fn main() {
    divan::main();
}

#[divan::bench(args = ["quick", "fat"])]
fn check_and_plan(bencher: divan::Bencher<'_, '_>, campaign: &str) {
    let wanted = Wanted { names: vec![campaign.to_owned()], ..Wanted::default() };
    bencher.bench_local(|| {
        let source = shipped::find(Folder::Rigs, "sim", None).expect("shipped");
        let rig = read_rig(source).expect("a shipped rig parses");
        plan(&wanted, &rig).expect("a shipped campaign plans").procedures.len()
    });
}
