//! The page itself.

use super::charts::{Curve, chart};
use super::tables::{cpu_table, event_table, tiles};
use crate::outcome::Outcome;
use crate::picture::{MapView, Role, SVG_STYLE, Sign, Sketch, escape, role_rules, svg};
use crate::record::{RunRecord, Sample};
use std::fmt::Write as _;

/// The whole run as one HTML file. It names nothing outside itself.
pub fn html(record: &RunRecord) -> String {
    let (map, signs) = MapView::new(record, 1040.0, 900.0).draw();
    let mut page = String::new();
    let _ = writeln!(page, "<p class=\"soft\">{}</p>", escape(&record.file));
    if let Some(outcome) = &record.outcome {
        verdict(&mut page, outcome);
    }
    let label = format!("Map of {}: {}", record.name, record.headline());
    let _ = write!(page, "<figure class=\"map\">\n{}</figure>\n", svg(&map, &label));
    legend(&mut page, &signs);
    charts(&mut page, &record.samples);
    if let Some(outcome) = &record.outcome {
        let _ = write!(page, "<h2>Figures</h2>\n{}", tiles(outcome));
        let _ = write!(page, "<h2>Events</h2>\n{}", event_table(record));
        let _ = write!(page, "<h2>Time used by each stage</h2>\n{}", cpu_table(outcome));
    }
    let config = escape(&record.config);
    let _ = write!(
        page,
        "<h2>Pipeline</h2>\n<details><summary>with all defaults</summary><pre>{config}</pre></details>\n"
    );
    document(&record.name, "", &page)
}

/// A page in the look of all reports: title, rules of its own, and what stands below the title.
pub fn document(title: &str, css: &str, body: &str) -> String {
    let (title, version) = (escape(title), env!("CARGO_PKG_VERSION"));
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>\n{}{css}{SVG_STYLE}\n{}@media (prefers-color-scheme:dark){{\n{}}}\n</style>\n</head>\n<body>\n<main>\n\
         <h1>{title}</h1>\n{body}<footer>Written by rumbo {version}.</footer>\n</main>\n</body>\n</html>\n",
        include_str!("page.css"),
        role_rules(false),
        role_rules(true),
    )
}

fn verdict(page: &mut String, outcome: &Outcome) {
    let class = if outcome.is_success() { "good" } else { "bad" };
    let reason = outcome.reason.to_string().replace('_', " ");
    let detail = outcome.detail.as_deref().map(|detail| format!(": {}", escape(detail))).unwrap_or_default();
    let (time_s, seed) = (outcome.time_s, outcome.seed);
    let _ = writeln!(
        page,
        "<p class=\"verdict\"><span class=\"{class}\">{reason}</span>{detail} \
         <span class=\"soft\">after {time_s:.1} s, seed {seed}</span></p>"
    );
    if let Some(hint) = outcome.hint() {
        let _ = writeln!(page, "<p>What to try: {}.</p>", escape(hint));
    }
}

fn legend(page: &mut String, signs: &[Sign]) {
    page.push_str("<ul class=\"legend\">\n");
    for sign in signs {
        let mut sample = Sketch::sheet(30.0, 14.0);
        match sign.role {
            Role::Truth | Role::Estimate | Role::Path | Role::OldPath | Role::Level | Role::Draft => {
                sample.chain(sign.role, vec![[1.0, 7.0], [29.0, 7.0]]);
            }
            Role::Obstacle | Role::Mark => sample.circle(sign.role, [15.0, 7.0], 4.0),
            _ => sample.circle(sign.role, [15.0, 7.0], 5.5),
        }
        let _ = writeln!(page, "<li>{}{}</li>", svg(&sample, sign.words).trim_end(), sign.words);
    }
    page.push_str("</ul>\n");
}

fn charts(page: &mut String, samples: &[Sample]) {
    let curve = |role, value: fn(&Sample) -> Option<f64>| Curve {
        role,
        points: samples.iter().map(|s| [s.time_s, value(s).unwrap_or(f64::NAN)]).collect(),
    };
    let error = [curve(Role::SecondCurve, |s| s.error_m().map(|m| m * 100.0))];
    let clearance = [curve(Role::Curve, |s| s.clearance_m)];
    let speed = [curve(Role::Curve, |s| Some(s.speed_m_s))];
    let turn = [curve(Role::Curve, |s| Some(s.turn_rad_s.to_degrees()))];
    let all = [
        ("Estimate to truth, cm", chart(&error, None, true)),
        ("Hull to the nearest obstacle, m", chart(&clearance, Some(0.0), true)),
        ("Commanded speed, m/s", chart(&speed, None, true)),
        ("Commanded turn, °/s", chart(&turn, None, true)),
    ];
    if all.iter().all(|(_, sketch)| sketch.is_none()) {
        return;
    }
    page.push_str("<h2>Over time</h2>\n<div class=\"charts\">\n");
    for (title, sketch) in all {
        let Some(sketch) = sketch else { continue };
        let _ = write!(page, "<figure><h3>{title}</h3>\n{}</figure>\n", svg(&sketch, title));
    }
    page.push_str("</div>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::test_record;

    #[test]
    fn a_page_names_nothing_outside_itself_and_lets_no_text_out() {
        let page = html(&test_record());
        for outside in ["http:", "https:", "src=", "<script", "@import", "<its>", "<1>"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(page.contains("data:image/png;base64,") && page.contains("&lt;its&gt;"));
    }

    #[test]
    fn every_tag_is_closed() {
        let page = html(&test_record());
        for tag in ["main", "svg", "table", "ul", "li", "dl", "div", "figure", "details", "pre", "p", "h2"] {
            let opened =
                page.matches(&format!("<{tag}>")).count() + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }

    #[test]
    fn a_run_that_failed_says_why_and_what_to_try() {
        let mut record = test_record();
        if let Some(outcome) = &mut record.outcome {
            outcome.arrived = false;
            outcome.reason = rumbo_core::engine::EndReason::Unreachable;
            outcome.detail = Some("a <door> is closed".into());
        }
        let page = html(&record);
        assert!(page.contains("a &lt;door&gt; is closed") && page.contains("What to try"));
    }
}
