use super::*;
use crate::diagnostic::{Diagnostic, SourceFile};
use crate::requirement::Requirements;

fn requirements() -> Requirements {
    let text = include_str!("../../../requirements.toml");
    Requirements::parse(&SourceFile::new("requirements.toml", text)).expect("the shipped requirements")
}

fn read(text: &str) -> Result<Criteria, Vec<Diagnostic>> {
    Criteria::parse(&SourceFile::new("regress.toml", text), &requirements())
}

fn one(keys: &str) -> Criterion {
    let read = read(&format!("schema = 1\n[[criterion]]\n{keys}"));
    read.unwrap_or_else(|mistakes| panic!("{}", mistakes[0])).all.remove(0)
}

fn mistakes(text: &str) -> String {
    let mistakes = read(text).expect_err("the file is wrong");
    mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_criterion_takes_measurand_scale_and_way_from_its_requirement() {
    let bandwidth = one("requirement = 'VEL-BW'\nmargin = '0.1 Hz'");
    assert_eq!(
        (bandwidth.measurand.as_str(), bandwidth.kind),
        ("velocity-bandwidth", QuantityKind::Frequency)
    );
    assert_eq!((bandwidth.scale, bandwidth.worse), (Scale::Difference, Worse::Lower));
    assert!(bandwidth.blocking && bandwidth.margin == 0.1);
    let rms = one("requirement = 'TRK-RMS-C'\nmargin = '5 %'\nblocking = false");
    assert_eq!((rms.scale, rms.worse, rms.blocking), (Scale::LogRatio, Worse::Higher, false));
    assert!((rms.margin - 1.05_f64.ln()).abs() < 1e-15);
    let goal = one("requirement = 'TRK-RMS-F'\nmargin = '5 %'");
    assert_eq!(goal.worse, Worse::Higher, "by its goal");
}

#[test]
fn a_criterion_may_say_itself_how_values_are_compared_and_which_way_is_worse() {
    let own = one("requirement = 'TRK-RMS-C'\nmargin = '5 urad'\nscale = 'difference'\nworse = 'lower'");
    assert_eq!((own.scale, own.worse), (Scale::Difference, Worse::Lower));
    assert!((own.margin - 5e-6).abs() < 1e-18);
    let within = one("requirement = 'GYR-SCALE'\nmargin = '20 ppm'\nworse = 'higher'");
    assert!((within.margin - 20e-6).abs() < 1e-18 && within.kind == QuantityKind::Ratio);
    let several = one("requirement = 'MOT-CUE'\nmeasurand = 'cue-settling-time'\nmargin = '5 %'");
    assert_eq!((several.measurand.as_str(), several.scale), ("cue-settling-time", Scale::LogRatio));
}

#[test]
fn the_looks_are_those_of_the_file_or_five_ten_twenty_and_forty() {
    let criterion = "[[criterion]]\nrequirement = 'VEL-BW'\nmargin = '0.1 Hz'\n";
    let looks = |line: &str| read(&format!("schema = 1\n{line}\n{criterion}")).expect("good looks").looks;
    assert_eq!(looks(""), [5, 10, 20, 40]);
    assert_eq!(looks("looks = [8, 12]"), [8, 12]);
    let wrong = ["[5, 5]", "[5, 11]", "[1]", "[]", "[2, 3, 4, 5, 6]", "[-3]", "'5'", "[5, 'ten']"];
    let told = wrong.map(|looks| mistakes(&format!("schema = 1\nlooks = {looks}\n{criterion}")));
    insta::assert_snapshot!(told.join("\n"));
}

#[test]
fn all_mistakes_of_a_criteria_file_come_at_once_with_what_to_do() {
    let criteria = [
        "requirement = 'VEL-BV'\nmargin = '0.1 Hz'",
        "requirement = 'VEL-BW'",
        "requirement = 'VEL-GM'\nmargin = '0 dB'",
        "requirement = 'VEL-PM'\nmargin = '2 Hz'",
        "requirement = 'TRK-RMS-C'\nmargin = '5 urad'",
        "requirement = 'MOT-CUE'\nmargin = '5 %'",
        "requirement = 'MOT-CUE'\nmeasurand = 'cue-overshoot'\nmargin = '5 urad'",
        "requirement = 'GYR-SCALE'\nmargin = '20 ppm'",
        "requirement = 'POS-TRK'\nmargin = '-5 %'\nscale = 'log'",
        "requirement = 'TRK-BW'\nmargin = '0.1 Hz'",
        "requirement = 'TRK-BW'\nmargin = '0.2 Hz'\nblock = true",
    ];
    let text: String = criteria.iter().map(|keys| format!("[[criterion]]\n{keys}\n")).collect();
    insta::assert_snapshot!(mistakes(&format!("schema = 1\n{text}")));
    insta::assert_snapshot!("empty", mistakes("schema = 1\ncriterion = []"));
}
