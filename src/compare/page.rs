//! `report.html`: one page that names nothing outside itself.

use super::by_world::{Line, Spread};
use super::design::Design;
use super::figures::FIGURES;
use super::pareto::OBJECTIVES_IN_WORDS;
use super::plots::{Row, bars, dots};
use super::statistics::N_RESAMPLES;
use super::summary::{Difference, Results, Standing, Summary};
use super::table::{letter, shown, success, titled, worlds};
use crate::picture::{escape, svg};
use crate::report;
use rumbo_core::engine::Part;
use std::fmt::Write as _;

/// Rules that only this page needs.
const CSS: &str = ".wide{overflow-x:auto}.wide td,.wide th{white-space:nowrap}.wide td+td,.wide th+th{text-align:right;padding-left:.9rem}.wide td:first-child{position:sticky;left:0;background:var(--paper)}\
.letters td:first-child{font-weight:600;width:2rem}\
.failures td:not(:last-child),.failures th:not(:last-child){white-space:nowrap;width:1%;padding-right:1.2rem}";

/// The whole comparison.
pub fn html(design: &Design, fingerprint: &str, results: &Results, summary: &Summary) -> String {
    let mut body = String::new();
    let (n_runs, n_done) = (design.runs().len(), results.len());
    let _ = writeln!(
        body,
        "<p class=\"soft\">{} alternatives, {} worlds, {} seeds: {n_done} of {n_runs} runs</p>",
        design.alternatives.len(),
        design.places.len(),
        design.seeds.len()
    );
    alternatives(&mut body, summary);
    plots(&mut body, design, results, summary);
    body.push_str("<h2>Figures</h2>\n");
    figures(&mut body, &summary.alternatives);
    for (world, lines) in &summary.by_world {
        by_world(&mut body, world, lines, &summary.alternatives);
    }
    if !summary.differences.is_empty() {
        body.push_str("<h2>Paired differences</h2>\n");
        differences(&mut body, summary);
    }
    failures(&mut body, design, results);
    method(&mut body, design, fingerprint);
    let file = design.base.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let title = if design.title.is_empty() { format!("Comparison: {file}") } else { design.title.clone() };
    report::document(&title, CSS, &body)
}

fn alternatives(body: &mut String, summary: &Summary) {
    body.push_str("<table class=\"letters\"><tbody>\n");
    for (idx, standing) in summary.alternatives.iter().enumerate() {
        let pareto = if standing.is_pareto { "<span class=\"good\">★ Pareto</span>" } else { "" };
        let (letter, name) = (letter(idx), escape(&standing.name));
        let _ = writeln!(body, "<tr><td>{letter}</td><td>{name}</td><td>{pareto}</td></tr>");
    }
    body.push_str("</tbody></table>\n");
    let _ = writeln!(
        body,
        "<p class=\"soft\">★: no other alternative is at least as good in all of {OBJECTIVES_IN_WORDS}, and better in one.</p>"
    );
}

fn plots(body: &mut String, design: &Design, results: &Results, summary: &Summary) {
    body.push_str("<h2>Runs</h2>\n<div class=\"charts\">\n");
    let shares: Vec<_> =
        summary.alternatives.iter().enumerate().map(|(idx, s)| (letter(idx), s.success)).collect();
    let mut add = |title: &str, sketch| {
        let _ = write!(body, "<figure><h3>{title}</h3>\n{}</figure>\n", svg(&sketch, title));
    };
    add("success, %", bars(&shares));
    for figure in &FIGURES {
        let row = |(idx, standing): (usize, &Standing)| Row {
            letter: letter(idx),
            values: results
                .iter()
                .filter(|(run, _)| run.alternative == idx)
                .filter_map(|(_, result)| figure.of(result))
                .collect(),
            mean: standing.figures.get(figure.key).map(|estimate| estimate.interval),
        };
        let rows: Vec<Row> = (0..design.alternatives.len()).zip(&summary.alternatives).map(row).collect();
        if let Some(sketch) = dots(figure, &rows) {
            add(&titled(figure.name, figure.unit), sketch);
        }
    }
    body.push_str(
        "</div>\n<p class=\"soft\">A dot is a run; the box holds its middle half, with the median; orange is the mean \
         with its 95 % interval.</p>\n",
    );
}

fn figures(body: &mut String, standings: &[Standing]) {
    body.push_str("<div class=\"wide\"><table><thead>\n");
    row(body, "th", "", (0..standings.len()).map(letter));
    body.push_str("</thead><tbody>\n");
    row(body, "td", "runs", standings.iter().map(|s| s.n.to_string()));
    row(body, "td", "success, %", standings.iter().map(|s| success(s.success)));
    for world in worlds(standings) {
        let cell = |s: &Standing| success(s.success_by_world.get(world).copied());
        row(body, "td", &format!("… in {}", escape(world)), standings.iter().map(cell));
    }
    let touched = |s: &Standing| s.n_with_contact.map_or("–".into(), |n| n.to_string());
    row(body, "td", "runs with contact", standings.iter().map(touched));
    for figure in &FIGURES {
        let cell = |s: &Standing| shown(s.figures.get(figure.key), |v| figure.show(v));
        row(body, "td", &titled(figure.name, figure.unit), standings.iter().map(cell));
    }
    let common = |s: &Standing| s.common_time_s.map_or("–".into(), |time_s| format!("{time_s:.1}"));
    row(body, "td", "time where all arrived, s", standings.iter().map(common));
    for part in Part::ALL {
        let cell = |s: &Standing| shown(s.cpu_s.get(part.name()), |v| format!("{:.1}", v * 1e3));
        let name = format!("CPU {}, ms a run", part.name().replace('_', " "));
        row(body, "td", &name, standings.iter().map(cell));
    }
    body.push_str("</tbody></table></div>\n");
}

fn by_world(body: &mut String, world: &str, lines: &[Line], standings: &[Standing]) {
    let _ = writeln!(body, "<h3>{}</h3>", escape(world));
    body.push_str("<div class=\"wide\"><table><thead>\n");
    row(body, "th", "", (0..standings.len()).map(letter));
    body.push_str("</thead><tbody>\n");
    row(body, "td", "success, %", standings.iter().map(|s| success(s.success_by_world.get(world).copied())));
    for line in lines {
        let mean = |cell: &Option<Spread>| cell.map_or("–".into(), |cell| cell.mean_in_words());
        let spread = |cell: &Option<Spread>| cell.map_or("–".into(), |cell| cell.spread_in_words());
        row(body, "td", &escape(&line.title), line.cells.iter().map(mean));
        row(body, "td", "… median / 95 % / worst", line.cells.iter().map(spread));
    }
    body.push_str("</tbody></table></div>\n");
}

fn differences(body: &mut String, summary: &Summary) {
    let place = |name: &str| summary.alternatives.iter().position(|s| s.name == name).map(letter);
    let head = |d: &Difference| {
        format!("{} − {}", place(&d.to).unwrap_or_default(), place(&d.from).unwrap_or_default())
    };
    body.push_str("<div class=\"wide\"><table><thead>\n");
    row(body, "th", "", summary.differences.iter().map(head));
    body.push_str("</thead><tbody>\n");
    let percent = |v: f64| format!("{:+.1}", v * 100.0);
    row(body, "td", "success, %", summary.differences.iter().map(|d| shown(d.success.as_ref(), percent)));
    for figure in &FIGURES {
        let signed = |v: f64| format!("{:+.*}", figure.digits, v * figure.scale);
        let cell = |d: &Difference| shown(d.figures.get(figure.key), signed);
        row(body, "td", &titled(figure.name, figure.unit), summary.differences.iter().map(cell));
    }
    body.push_str("</tbody></table></div>\n");
}

fn row(body: &mut String, tag: &str, name: &str, cells: impl Iterator<Item = String>) {
    let _ = write!(body, "<tr><{tag}>{name}</{tag}>");
    for cell in cells {
        let _ = write!(body, "<{tag}>{}</{tag}>", escape(&cell));
    }
    body.push_str("</tr>\n");
}

/// Runs without success, with what they said.
fn failures(body: &mut String, design: &Design, results: &Results) {
    const MOST: usize = 200;
    let failed: Vec<_> = results.iter().filter(|(_, result)| !result.is_success()).collect();
    if failed.is_empty() {
        return;
    }
    body.push_str(
        "<h2>Runs without success</h2>\n<div class=\"scroll\"><table class=\"failures\"><thead><tr><th></th><th>world</th><th>seed</th>\
         <th>mission</th><th>end</th><th>what it said</th></tr></thead><tbody>\n",
    );
    for (run, result) in failed.iter().take(MOST) {
        let (letter, world) = (letter(run.alternative), escape(design.place_name(run)));
        let detail = escape(result.detail.as_deref().unwrap_or(""));
        let _ = writeln!(
            body,
            "<tr><td>{letter}</td><td>{world}</td><td>{}</td><td>{}</td><td>{}</td><td>{detail}</td></tr>",
            run.seed,
            run.mission,
            escape(&result.end)
        );
    }
    body.push_str("</tbody></table></div>\n");
    if failed.len() > MOST {
        let _ = writeln!(body, "<p>… and {} more in results.csv.</p>", failed.len() - MOST);
    }
}

fn method(body: &mut String, design: &Design, fingerprint: &str) {
    let worlds: Vec<&str> = design.places.iter().map(|place| place.name.as_str()).collect();
    let seeds = (design.seeds.first().copied().unwrap_or(0), design.seeds.last().copied().unwrap_or(0));
    let ranges: Vec<String> =
        design.ranges.iter().map(|range| format!("{}={}..{}", range.key, range.low, range.high)).collect();
    let listed = |items: &[String]| if items.is_empty() { "none".to_owned() } else { items.join(", ") };
    let mut rows = vec![
        ("pipeline", design.base.display().to_string()),
        ("worlds", worlds.join(", ")),
        ("seeds", format!("{} to {}", seeds.0, seeds.1)),
        ("values set", listed(&design.sets)),
        ("values drawn for each seed", listed(&ranges)),
        ("design", fingerprint.to_owned()),
        ("version", format!("rumbo {}", env!("CARGO_PKG_VERSION"))),
    ];
    rows.push(("intervals", format!(
        "95 %: Wilson for success; percentile bootstrap with {N_RESAMPLES} resamples for means. They speak of other \
         seeds in these worlds, not of other worlds. Time, way, detour and turns are of runs that succeeded."
    )));
    rows.push(("Pareto set", OBJECTIVES_IN_WORDS.to_owned()));
    body.push_str("<h2>Design</h2>\n<table><tbody>\n");
    for (name, value) in &rows {
        let _ = writeln!(body, "<tr><td>{name}</td><td>{}</td></tr>", escape(value));
    }
    body.push_str("</tbody></table>\n");
}
