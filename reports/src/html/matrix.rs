//! The verification matrix: one row a requirement, and what was not measured.

use super::{badge, measurement_anchor, section, table_head};
use crate::markup::Markup;
use crate::number;
use crate::record::Findings;
use crate::row::{self, Evidence, Row};

const HEAD: [(&str, &str); 9] = [
    ("", "Requirement"),
    ("", "Demand"),
    ("n", "Value"),
    ("n", "U"),
    ("", "Limit"),
    ("", "Rule"),
    ("n", "Margin"),
    ("", "Verdict"),
    ("", "Evidence"),
];

/// The matrix and the list of what was not measured.
pub(super) fn write(m: &mut Markup, findings: &Findings) {
    section(m, "requirements", "Requirements");
    m.open("table", &[("class", "matrix")]);
    table_head(m, &HEAD);
    m.open("tbody", &[]);
    let rows = row::rows(findings);
    for row in rows.iter().filter(|r| r.evidence.is_some()) {
        write_row(m, findings, row);
    }
    m.close();
    m.close();
    m.close();
    let missing: Vec<&Row<'_>> = rows.iter().filter(|r| r.evidence.is_none()).collect();
    let named = row::named_only(findings);
    if missing.is_empty() && named.is_empty() {
        return;
    }
    section(m, "not-measured", "Not measured");
    if !missing.is_empty() {
        not_measured(m, &missing);
    }
    for (why, ids) in named {
        m.element("p", &[], &format!("Also {why}: {}.", ids.join(", ")));
    }
    m.close();
}

fn write_row(m: &mut Markup, findings: &Findings, row: &Row<'_>) {
    let id = format!("requirement-{}", anchor(&row.requirement.id));
    m.open("tr", &[("id", &id)]);
    m.element("th", &[("scope", "row")], &row.requirement.id);
    m.within("td", &[], |m| demand(m, row));
    m.element("td", &[("class", "n")], &row.value);
    m.element("td", &[("class", "n")], &row.expanded_u);
    m.within("td", &[("class", "limit")], |m| {
        m.text(&row.limit);
        small(m, row.goal.as_deref());
    });
    m.element("td", &[("class", "rule")], row.rule);
    m.within("td", &[("class", "n")], |m| {
        m.text(&row.margin);
        small(m, row.margin_percent().as_deref());
    });
    m.within("td", &[], |m| {
        badge(m, row.sign);
        small(m, row.reason.as_deref());
        small(m, row.probability_outside.as_ref().map(|p| format!("P(outside) {p}")).as_deref());
    });
    m.within("td", &[("class", "evidence")], |m| {
        if let Some(evidence) = &row.evidence {
            link(m, findings, evidence);
        }
    });
    m.close();
}

fn demand(m: &mut Markup, row: &Row<'_>) {
    let requirement = row.requirement;
    m.text(&requirement.text);
    if !requirement.conditions.is_empty() {
        let conditions: Vec<String> = requirement.conditions.iter().map(|c| number::typeset(c)).collect();
        small(m, Some(&format!("judged where {}", conditions.join(", "))));
    }
    small(m, Some(&format!("{}; source {}", requirement.method, requirement.source)));
}

fn link(m: &mut Markup, findings: &Findings, evidence: &Evidence<'_>) {
    let Some(index) = findings.procedures.iter().position(|p| p.id == evidence.procedure) else { return };
    let to = format!("#{}", measurement_anchor(index, evidence.measurement));
    m.element("a", &[("href", &to)], evidence.procedure);
    small(m, evidence.point);
    if evidence.judged > 1 {
        small(m, Some(&format!("worst of {}", evidence.judged)));
    }
}

fn small(m: &mut Markup, text: Option<&str>) {
    if let Some(text) = text.filter(|t| !t.is_empty()) {
        m.element("small", &[], text);
    }
}

/// Letters that an anchor may have.
fn anchor(id: &str) -> String {
    id.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
}

fn not_measured(m: &mut Markup, rows: &[&Row<'_>]) {
    m.open("table", &[]);
    table_head(m, &[("", "Requirement"), ("", "Demand"), ("", "Limit"), ("", "Why")]);
    m.open("tbody", &[]);
    for row in rows {
        m.open("tr", &[]);
        m.element("th", &[("scope", "row")], &row.requirement.id);
        m.within("td", &[], |m| demand(m, row));
        m.element("td", &[("class", "limit")], &row.limit);
        m.within("td", &[], |m| {
            let text = row.reason.as_deref().unwrap_or("judged, but the measurement is not in this report");
            if row.requirement.required {
                m.element("strong", &[], "Required: ");
            }
            m.text(text);
        });
        m.close();
    }
    m.close();
    m.close();
}
