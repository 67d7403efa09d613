use procedures::verdict::{Overall, Verdict};
use proptest::prelude::*;

use super::*;
use crate::markup::tests::malformed;
use crate::record::Origin;

mod bands;
mod junit;

/// The sample without pictures: those have snapshots of their own.
fn without_pictures() -> Results {
    let mut results = sample::results();
    results.findings.procedures.iter_mut().for_each(|p| p.plots.clear());
    results
}

fn rendered(name: &str, results: &Results) -> String {
    let content = (format(name).expect("it is in the list").render)(results);
    String::from_utf8(content).expect("this format is text")
}

/// What a format that is not text looks like is for its own tests.
#[test]
fn every_text_format_of_the_sample() {
    let results = without_pictures();
    for format in FORMATS {
        if let Ok(text) = String::from_utf8((format.render)(&results)) {
            insta::assert_snapshot!(format.file, text);
        }
    }
}

#[test]
fn every_format_is_the_same_bytes_twice() {
    let results = sample::results();
    for format in FORMATS {
        assert_eq!((format.render)(&results), (format.render)(&results.clone()), "{}", format.name);
    }
}

#[test]
fn names_and_files_of_formats_are_unique() {
    for (i, a) in FORMATS.iter().enumerate() {
        for b in &FORMATS[..i] {
            assert!(a.name != b.name && a.file != b.file, "{} {}", a.name, b.name);
        }
    }
    assert!(format("pdf").is_none());
}

/// The page without its scripts, and the scripts: where they end in a page is where a browser ends them.
fn parted(page: &str) -> (String, Vec<&str>) {
    let mut rest = page;
    let mut markup = String::new();
    let mut scripts = Vec::new();
    while let Some((before, after)) = rest.split_once("<script") {
        markup += before;
        let (attributes, after) = after.split_once('>').expect("the tag ends");
        let (script, after) = after.split_once("</script>").expect("the element ends");
        let data = attributes == " type=\"application/json\"";
        assert!(data || attributes.is_empty(), "{attributes}");
        scripts.push(script);
        rest = after;
    }
    (markup + rest, scripts)
}

#[test]
fn the_page_is_well_formed_and_fetches_nothing() {
    let page = rendered("html", &sample::with_responses());
    let (markup, scripts) = parted(&page);
    assert_eq!(malformed(&markup), None);
    for forbidden in ["http://", "https://", "<link", "@import", "url(", "<img", "<iframe"] {
        let found = markup.replace("http://www.w3.org/2000/svg", "").contains(forbidden);
        assert!(!found, "{forbidden} in the page");
    }
    assert!(markup.contains("default-src &#39;none&#39;"), "and a browser keeps it from fetching");
    assert_eq!(markup.matches("<svg xmlns").count(), 14, "every figure is drawn");
    assert_eq!(scripts.len(), 15, "data of every figure, and one script");
}

#[test]
fn every_figure_carries_its_data_and_a_page_without_figures_no_script() {
    let results = sample::with_responses();
    let page = rendered("html", &results);
    let (_, scripts) = parted(&page);
    let mut panels = Vec::new();
    for data in &scripts[..14] {
        let value: serde_json::Value = serde_json::from_str(data).expect("data of a figure is JSON");
        panels.extend(value["panels"].as_array().expect("panels").clone());
    }
    let plots: Vec<_> = results.findings.procedures.iter().flat_map(|p| &p.plots).collect();
    assert_eq!(panels.len(), plots.len());
    for (panel, plot) in panels.iter().zip(plots) {
        // One by one, or as differences.
        let list = |key: &str| panel["series"][0][key].clone();
        let points = |key: &str| list(key).as_array().or(list(key)["d"].as_array()).map(Vec::len);
        assert_eq!(points("x"), Some(plot.series[0].x.len()), "{}", plot.id);
        assert_eq!(points("y"), Some(plot.series[0].y.len()), "{}", plot.id);
    }
    assert!(!rendered("html", &without_pictures()).contains("<script"));
}

#[test]
fn simulated_results_carry_the_mark_on_screen_and_on_every_printed_page() {
    let mut results = sample::results();
    let page = rendered("html", &results);
    assert!(page.contains("class=\"watermark\" aria-hidden=\"true\">SIMULATED</div>"));
    assert!(page.contains("@top-right { content: \"DRAFT · SIMULATED\"; }"));
    assert!(rendered("md", &results).contains("**SIMULATED**"));
    results.findings.origin = Origin::Real;
    let page = rendered("html", &results);
    assert!(!page.contains("class=\"watermark\"") && !page.contains("not evidence of the conformity"));
}

#[test]
fn links_lead_to_anchors_that_exist_once() {
    let results = sample::results();
    let page = rendered("html", &results);
    let ids: Vec<&str> = page.split(" id=\"").skip(1).filter_map(|t| t.split('"').next()).collect();
    for (i, id) in ids.iter().enumerate() {
        assert!(!ids[..i].contains(id), "{id} twice");
    }
    let links: Vec<&str> = page.split("href=\"#").skip(1).filter_map(|t| t.split('"').next()).collect();
    for link in &links {
        assert!(ids.contains(link), "{link} leads nowhere");
    }
    let leads = |to: &str| links.contains(&to);
    assert!(leads("safety") && leads("procedure-1") && leads("procedure-2"));
    for id in ["FRC-AZ", "HOLD-EL", "UNB-EL", "SPR-EL"] {
        assert!(leads(&format!("requirement-{id}")), "{id} falls short and is named on the first page");
    }
    let measured = results.findings.outcomes.iter().filter(|o| o.judged > 0).count();
    let evidence = links.iter().filter(|l| l.contains("-measurement-")).count();
    assert_eq!(evidence, measured, "the matrix leads from every requirement to what decided it");
}

/// The part of a page that an element with this id holds, up to the next section.
fn part<'a>(page: &'a str, id: &str) -> &'a str {
    let after = page.split(&format!("id=\"{id}\"")).nth(1).expect("it is in the page");
    after.split("<section").next().expect("it has an end")
}

#[test]
fn the_first_page_says_which_requirements_fall_short_and_why() {
    let page = rendered("html", &sample::results());
    let first = part(&page, "result");
    let rows: Vec<&str> = first.split("<tr>").filter(|row| row.contains("#requirement-")).collect();
    let places: Vec<usize> = ["FRC-AZ", "HOLD-EL", "UNB-EL", "SPR-EL"]
        .map(|id| rows.iter().position(|row| row.contains(&format!(">{id}<"))).expect("it is named"))
        .into();
    assert_eq!(places, [0, 1, 2, 3], "the worst first");
    assert!(
        rows[0]
            .contains("529.9\u{a0}N·m (U 5.7\u{a0}N·m) is outside ≤ 260\u{a0}N·m by 269.9\u{a0}N·m (104 %)")
    );
    assert!(rows[1].contains("loose after the ramp"), "{}", rows[1]);
    assert!(rows[2].contains("less than the guard band of 1.6\u{a0}N·m; P(outside) 14 %"), "{}", rows[2]);
    assert!(rows[3].contains("nothing was measured"), "{}", rows[3]);
}

#[test]
fn margins_stand_in_the_order_of_their_distance_to_the_guard_band_in_uncertainties() {
    let page = rendered("html", &sample::results());
    let table = part(&page, "result").split("Margins, worst first").nth(1).expect("there are margins");
    let order: Vec<&str> = table.split("#requirement-").skip(1).filter_map(|t| t.split('"').next()).collect();
    assert_eq!(order, ["FRC-AZ", "UNB-EL", "SPR-AZ", "COG-AZ", "FRC-EL"], "whatever part of its limit it is");
    assert!(table.contains("<td class=\"n\">−47 U</td>"), "{table}");
}

#[test]
fn a_page_without_shortfalls_says_so() {
    let mut results = without_pictures();
    results.findings.outcomes.retain(|o| o.verdict == Verdict::Pass);
    results.findings.requirements.retain(|r| ["SPR-AZ", "COG-AZ", "FRC-EL"].contains(&r.id.as_str()));
    let page = rendered("html", &results);
    assert!(part(&page, "result").contains("None: every judged requirement passed"));
}

#[test]
fn the_matrix_has_a_row_for_what_is_declared_and_names_what_nothing_covers() {
    let mut results = without_pictures();
    let pointing = results.findings.requirements.iter_mut().find(|r| r.id == "POS-ACC").expect("it is there");
    pointing.evidence = Some("report 4711, section 3".to_owned());
    pointing.method = "inspection".to_owned();
    let page = rendered("html", &results);
    let row = part(&page, "requirement-POS-ACC").split("</tr>").next().expect("a row");
    assert!(
        row.contains(">I</td>") && row.contains("declared") && row.contains("report 4711, section 3"),
        "{row}"
    );
    let gaps = part(&page, "not-measured");
    for (ids, why) in [
        ("SPR-EL", "required, but nothing was measured"),
        ("FSM-BW, STR-XAX", "no kind of procedure measures it yet"),
    ] {
        assert!(gaps.contains(&format!("{ids}: {why}.")), "{gaps}");
    }
    assert!(!gaps.contains("POS-ACC"));
}

#[test]
fn a_method_stands_where_its_kind_comes_first() {
    let mut results = without_pictures();
    let again = results.findings.procedures[0].clone();
    results.findings.procedures.push(again);
    let page = rendered("html", &results);
    assert!(part(&page, "procedure-1").contains("<h3>Method</h3>"));
    let third = part(&page, "procedure-3");
    assert!(third.contains("Method: that of <a href=\"#procedure-1\">1. AZ-FRICTION</a>"), "{third}");
}

#[test]
fn a_requirement_without_an_entry_is_still_listed_as_not_measured() {
    let results = sample::results();
    assert!(results.findings.requirement("STR-XAX").is_none());
    for name in ["html", "md", "junit"] {
        assert!(rendered(name, &results).contains("STR-XAX"), "{name}");
    }
    assert!(rendered("html", &results).contains("10 requirements: 1 fail"));
}

#[test]
fn requirements_as_a_table_have_one_row_a_limit_with_the_value_in_its_unit_and_in_si() {
    let results = sample::results();
    let records = csv_records(&rendered("requirements-csv", &results));
    let column = |name: &str| records[0].iter().position(|c| c == name).expect("it has a head");
    let rows: Vec<&Vec<String>> = records[1..].iter().collect();
    let cell = |row: &[String], name: &str| row[column(name)].clone();
    let friction = rows.iter().find(|row| cell(row, "requirement") == "FRC-AZ").expect("it was judged");
    assert_eq!([cell(friction, "limit"), cell(friction, "limit_unit")], ["<= 260 N*m", "N*m"]);
    assert_eq!(cell(friction, "value"), cell(friction, "value_si"), "SI is its unit");
    assert_eq!(cell(friction, "verdict"), "fail");
    let ids: Vec<String> = rows.iter().map(|row| cell(row, "requirement")).collect();
    for requirement in &results.findings.requirements {
        assert!(ids.contains(&requirement.id), "{}", requirement.id);
    }
    assert!(ids.contains(&"STR-XAX".to_owned()), "what is only named has a row, too");
}

#[test]
fn each_condition_has_columns_of_its_own_with_its_unit() {
    let records = csv_records(&rendered("csv", &sample::results()));
    let asked = records[0].iter().position(|c| c == "velocity asked [rad/s]").expect("a column");
    let reached = records[0].iter().position(|c| c == "velocity reached [rad/s]").expect("a column");
    let first: Vec<f64> = [asked, reached].map(|k| records[1][k].parse().expect("a number")).into();
    assert!((first[0] - 0.0349).abs() < 1e-4 && (first[1] / first[0] - 1.0).abs() < 0.05, "{first:?}");
}

#[test]
fn every_verdict_has_its_own_word_and_symbol() {
    for (i, &a) in words::VERDICTS.iter().enumerate() {
        for &b in &words::VERDICTS[..i] {
            let a = words::verdict(a);
            let b = words::verdict(b);
            assert!(a.word != b.word && a.symbol != b.symbol, "{a:?} {b:?}");
        }
    }
}

#[test]
fn the_page_shows_each_overall_outcome() {
    use Overall::{ConditionalFail, ConditionalPass, Fail, Incomplete, Inconclusive, Pass};
    for overall in [Pass, ConditionalPass, Incomplete, Inconclusive, ConditionalFail, Fail] {
        let mut results = without_pictures();
        results.findings.overall = overall;
        let sign = words::overall(overall);
        let banner = format!("aria-hidden=\"true\">{}</span> {}</p>", sign.symbol, sign.word);
        assert!(rendered("html", &results).contains(&banner), "{overall:?}");
    }
}

/// Records of an RFC 4180 text.
fn csv_records(text: &str) -> Vec<Vec<String>> {
    let mut records = Vec::new();
    let mut record = Vec::new();
    let mut cell = String::new();
    let mut quoted = false;
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if quoted && chars.peek() == Some(&'"') => {
                cell.push('"');
                chars.next();
            }
            '"' => quoted = !quoted,
            ',' if !quoted => record.push(std::mem::take(&mut cell)),
            '\r' if !quoted && chars.peek() == Some(&'\n') => {
                chars.next();
                record.push(std::mem::take(&mut cell));
                records.push(std::mem::take(&mut record));
            }
            c => cell.push(c),
        }
    }
    assert!(!quoted && cell.is_empty() && record.is_empty(), "the text ends with a record");
    records
}

#[test]
fn csv_numbers_read_back_to_the_same_bits() {
    let results = sample::results();
    let records = csv_records(&rendered("csv", &results));
    let column = records[0].iter().position(|c| c == "value").expect("it has a head");
    let values: Vec<Option<f64>> = records[1..].iter().map(|r| r[column].parse().ok()).collect();
    let expected: Vec<Option<f64>> =
        results.findings.procedures.iter().flat_map(|p| &p.measurements).map(|m| m.value).collect();
    assert_eq!(values, expected);
}

/// The sample with one text in every field that takes text.
fn with_text(text: &str) -> Results {
    let mut results = sample::results();
    let text = || text.to_owned();
    let findings = &mut results.findings;
    findings.unit = text();
    findings.campaign.title = text();
    findings.campaign.id = text();
    findings.requirements[0].text = text();
    findings.requirements[0].source = text();
    findings.requirements[0].conditions = vec![text()];
    if let Some(limit) = &mut findings.requirements[0].judges[0].limit {
        limit.text = text();
    }
    let procedure = &mut findings.procedures[0];
    procedure.id = text();
    procedure.title = text();
    procedure.method = text();
    procedure.remarks = vec![text()];
    procedure.log = Some(text());
    procedure.points[0].point = text();
    procedure.points[0].reason = Some(text());
    let measurement = &mut procedure.measurements[0];
    measurement.measurand = text();
    measurement.flags = vec![text()];
    measurement.excluded[0].reason = text();
    measurement.conditions[0].name = text();
    measurement.evidence[0].file = text();
    procedure.judgements[0].reason = Some(text());
    procedure.judgements[0].verdict = Verdict::Inconclusive;
    let plot = &mut procedure.plots[1];
    plot.title = text();
    plot.x.label = text();
    plot.y.unit = text();
    plot.series[0].label = text();
    plot.limits[0].label = text();
    results.record.operator = Some(text());
    results.record.title_page.report_id = Some(text());
    results.record.command_line = text();
    results.record.station = Some(text());
    results.record.started_utc = Some(text());
    results.record.files[0].file = text();
    results.record.prompts[0].text = text();
    results.record.prompts[0].answer = text();
    results.record.waivers[0].number = text();
    results.record.waivers[0].reason = text();
    results
}

#[test]
fn no_field_becomes_an_element() {
    let results = with_text("</style></title></svg>--><script>alert('x')</script>\" onload=\"x");
    let page = rendered("html", &results);
    let (markup, scripts) = parted(&page);
    assert_eq!(malformed(&markup), None);
    assert_eq!(scripts.len(), 5, "ours only");
    assert!(!markup.contains("\" onload"), "escaped everywhere");
    assert!(markup.contains("&lt;script&gt;"), "but still there to read");
    assert!(!rendered("md", &results).contains("<script"));
    assert_eq!(malformed(&rendered("junit", &results)), None);
}

#[test]
fn no_cell_of_a_spreadsheet_starts_a_formula() {
    for text in ["=1+1", "+1", "-1", "@SUM(A1)", " =1", "\t=1", "|cmd", "\r\n=1"] {
        for record in &csv_records(&rendered("csv", &with_text(text)))[1..] {
            for cell in record {
                let formula = cell.trim_start().starts_with(['=', '+', '-', '@', '|']);
                assert!(!formula || cell.parse::<f64>().is_ok(), "{cell:?}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_leaves_every_format_well_formed(text in "(<script>|</|[\"'&<>,;=\n\r\t|`]|\\PC|[\\x00-\\x1f]){0,12}") {
        let results = with_text(&text);
        let page = rendered("html", &results);
        let (markup, scripts) = parted(&page);
        prop_assert_eq!(malformed(&markup), None);
        prop_assert_eq!(scripts.len(), 5, "ours only");
        prop_assert_eq!(malformed(&rendered("junit", &results)), None);
        for name in ["html", "md", "junit", "csv", "requirements-csv"] {
            let steers =
                |c: char| c.is_control() && c != '\n' && c != '\t' && (c != '\r' || !name.ends_with("csv"));
            prop_assert!(!rendered(name, &results).contains(steers), "{} steers a terminal", name);
        }
        let records = csv_records(&rendered("csv", &results));
        prop_assert!(records.iter().all(|r| r.len() == records[0].len()));
        prop_assert_eq!(json::parse(&rendered("json", &results)).expect("own output"), results);
    }
}

#[test]
fn trips_and_stops_beyond_what_was_computed_stand_on_the_front_page_and_quiet_runs_say_nothing() {
    let mut results = sample::results();
    for (name, mark) in [("html", "EXCEEDED"), ("md", "✗ EXCEEDED")] {
        let text = rendered(name, &results);
        assert!(text.contains("FINDING: stopped beyond the computed worst case"), "{name}");
        assert!(text.contains("1 trip (AZ-FRICTION)") && text.contains(mark), "{name}");
    }
    for procedure in &mut results.findings.procedures {
        let safety = procedure.safety.as_mut().expect("the sample has it");
        safety.trips.clear();
        safety.stops.retain(|stop| !stop.exceeds());
    }
    let page = rendered("html", &results);
    assert!(!page.contains("class=\"alarm\"") && page.contains("1 stop in motion, within"));
}

#[test]
fn a_trip_that_a_procedure_is_there_to_provoke_alarms_nobody() {
    let mut results = sample::results();
    let procedure = &mut results.findings.procedures[0];
    procedure.kind = "range".to_owned();
    let safety = procedure.safety.as_mut().expect("the sample has it");
    safety.stops.clear();
    safety.trips[0].reason = "braking curve: az: 29.1 deg, limit 30 deg".to_owned();
    let page = rendered("html", &results);
    assert!(!page.contains("class=\"alarm\""));
    assert!(
        page.contains("of them provoked deliberately by moves past a limit")
            && page.contains("first out, provoked")
    );
    let safety = results.findings.procedures[0].safety.as_mut().expect("the sample has it");
    safety.trips[0].reason = "following error: az".to_owned();
    assert!(rendered("html", &results).contains("1 trip (AZ-FRICTION)"), "nobody ordered that one");
}

#[test]
fn results_from_before_there_was_a_safety_page_still_read_and_have_none() {
    let mut results = sample::results();
    results.findings.not_enforced.clear();
    results.findings.procedures.iter_mut().for_each(|p| p.safety = None);
    let text = rendered("json", &results);
    assert!(!text.contains("\"safety\":") && !text.contains("not_enforced"));
    assert_eq!(json::parse(&text).expect("own output"), results);
    assert!(!rendered("html", &results).contains("id=\"safety\""));
}

#[test]
fn a_stop_with_a_number_that_is_none_counts_as_one_that_did_not_come_to_rest() {
    let mut results = sample::results();
    let safety = results.findings.procedures[0].safety.as_mut().expect("the sample has it");
    safety.stops[1].reached_angle_rad = f64::NAN;
    assert!(!safety.stops[1].exceeds());
    results.make_finite();
    let safety = results.findings.procedures[0].safety.as_ref().expect("the sample has it");
    assert!(safety.stops[1].exceeds());
}

#[test]
fn many_conditions_share_a_column_so_that_the_table_is_no_wider_than_a_sheet() {
    let mut results = without_pictures();
    let point = &mut results.findings.procedures[0].points[0];
    let velocity = point.conditions[0].clone();
    for name in ["pose", "level"] {
        point
            .conditions
            .push(procedures::measurement::Condition { name: name.to_owned(), ..velocity.clone() });
    }
    let page = rendered("html", &results);
    let section = part(&page, "procedure-1");
    assert!(section.contains(">Condition: asked, reached</th>") && !section.contains(">asked</th>"));
    assert!(section.contains("velocity, °/s: 2, 2.000<br/>pose, °/s: 2, 2.000<br/>level"), "{section}");
    assert!(part(&page, "procedure-2").contains(">asked</th>"), "few have columns of their own");
}

#[test]
fn a_measurement_of_another_axis_than_its_procedures_says_which() {
    let mut results = without_pictures();
    results.findings.procedures[0].measurements[0].axis = "gyro-x".to_owned();
    let page = rendered("html", &results);
    let section = part(&page, "procedure-1");
    assert_eq!(
        section.matches("<small>gyro-x").count(),
        2,
        "in the table of points and in that of measurements"
    );
}
