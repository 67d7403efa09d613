//! What people write, and the plan that comes of it.

use super::*;
use crate::diagnostic::SourceFile;
use crate::procedure::Procedure;

fn parse(keys: &str) -> Result<Procedure, String> {
    let text = format!("schema = 1\nid = 'P'\ntitle = 't'\nkind = 'fsm-response'\naxis = 'az'\n{keys}");
    Procedure::parse(SourceFile::new("p.toml", text))
        .map_err(|all| all.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

#[test]
fn the_plan_holds_every_axis_level_and_channel_once() {
    let procedure = parse("stroke = {}\nharmonics = {}\n").expect("it is right");
    let cases = procedure.plan(&with_elevation(), &[]).expect("the rig has the axis");
    let lines: Vec<String> = cases
        .iter()
        .map(|c| {
            let channel = c.mirror_channel.map_or("", word);
            format!("{}: {} segments, {:.2} s, {channel}", c.point, c.segments.len(), c.planned_s())
        })
        .collect();
    insta::assert_snapshot!(lines.join("\n"));
    assert!(cases.iter().all(|c| c.logs_payload_fully && c.axis == "az"));
    let peak = cases[0].excitations[0].peak();
    assert!((240e-6..300e-6).contains(&peak), "{peak}");
}

#[test]
fn a_campaign_can_take_one_level() {
    let procedure = parse("").expect("it is right");
    let subset = crate::procedure::Subset { condition: "level".to_owned(), values: vec![2.0] };
    let cases = procedure.plan(&with_elevation(), &[subset]).expect("there is one");
    assert_eq!(cases.len(), 4);
}

#[test]
fn wrong_keys_are_pointed_at_together() {
    let wrong = parse(concat!(
        "mirror-axis = ['az', 'ez']\nchannel = ['analog', 'analog']\nlevel = ['0 V']\nplace = 'desk'\n",
        "[multisine]\nrange = '1 Hz .. 1500 Hz'\nreaction = '60 Hz .. 2000 Hz'\nperiods = 6\n"
    ));
    insta::assert_snapshot!(wrong.expect_err("five mistakes"));
}

#[test]
fn it_yields_what_its_keys_ask_for() {
    let all = keys().yields().expect("what its keys ask for");
    assert!(all.contains(&"mirror-stroke") && all.contains(&"channel-phase-difference"));
    let less = Keys { channels: vec![MirrorChannel::Serial], stroke: None, ..keys() };
    let expected = ["mirror-bandwidth", "mirror-attenuation-100-hz", "reaction-resonance"];
    assert_eq!(
        less.yields().expect("less than all"),
        expected.into_iter().chain(response::MARGINS.map(|(name, _)| name)).collect::<Vec<_>>()
    );
}
