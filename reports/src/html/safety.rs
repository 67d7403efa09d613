//! The safety page: trips, stops reached against computed, how the axes were left, what remains.

use super::{badge, section, table_head};
use crate::markup::Markup;
use crate::record::Findings;
use crate::{safety, words};

/// The whole section; nothing where no log tells of it.
pub(super) fn write(m: &mut Markup, findings: &Findings) {
    if !safety::is_known(findings) {
        return;
    }
    section(m, "safety", "Safety");
    m.element("p", &[], &safety::summary(findings));
    table(m, "Trips", &safety::TRIP_HEAD, &safety::trips(findings));
    stops(m, findings);
    table(m, "Worst cases, computed before any motion", &safety::WORST_HEAD, &safety::worst(findings));
    table(m, "How the axes were left", &safety::LEFT_HEAD, &safety::left(findings));
    table(
        m,
        "Monitored by the bench alone in torque mode (CST)",
        &safety::NOT_ENFORCED_HEAD,
        &safety::not_enforced(findings),
    );
    let risks = safety::risks(findings);
    if !risks.is_empty() {
        m.element("h3", &[], "Residual risks");
        m.open("ul", &[]);
        for risk in risks {
            m.element("li", &[], risk);
        }
        m.close();
    }
    m.close();
}

fn table<const N: usize>(m: &mut Markup, heading: &str, head: &[&str; N], rows: &[[String; N]]) {
    if rows.is_empty() {
        return;
    }
    m.element("h3", &[], heading);
    m.open("table", &[("class", "safety")]);
    table_head(m, &head.map(|cell| ("", cell)));
    m.open("tbody", &[]);
    for row in rows {
        m.open("tr", &[]);
        cells(m, row);
        m.close();
    }
    m.close();
    m.close();
}

/// The first cell heads its row.
fn cells(m: &mut Markup, row: &[String]) {
    for (index, cell) in row.iter().enumerate() {
        if index == 0 {
            m.element("th", &[("scope", "row")], cell);
        } else {
            m.element("td", &[], cell);
        }
    }
}

fn stops(m: &mut Markup, findings: &Findings) {
    let rows = safety::stops(findings);
    if rows.is_empty() {
        return;
    }
    m.element("h3", &[], "Stops in motion");
    m.open("table", &[("class", "safety")]);
    table_head(m, &safety::STOP_HEAD.map(|cell| ("", cell)));
    m.open("tbody", &[]);
    for (row, stop) in rows {
        m.open("tr", &[]);
        cells(m, &row);
        m.within("td", &[], |m| badge(m, words::against_computed(stop)));
        m.close();
    }
    m.close();
    m.close();
}
