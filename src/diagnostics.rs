//! Faults of a pipeline as people read them: file, line, the place underlined, and what to do.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use rumbo_core::document::{Fault, Faults, Origin, Source, SourceName, Sources};
use std::ops::Range;

/// All faults, one below the other, in the order in which they are.
pub fn render(faults: &Faults, sources: &Sources, with_color: bool) -> String {
    let n_faults = match faults.len() {
        1 => "1 fault".to_owned(),
        many => format!("{many} faults"),
    };
    format!("{}\n\n{n_faults}", below_each_other(Level::ERROR, faults, sources, with_color))
}

/// The same of what is only doubtful.
pub fn render_warnings(warnings: &Faults, sources: &Sources, with_color: bool) -> String {
    below_each_other(Level::WARNING, warnings, sources, with_color)
}

fn below_each_other(level: Level<'_>, faults: &Faults, sources: &Sources, with_color: bool) -> String {
    let renderer = if with_color { Renderer::styled() } else { Renderer::plain() };
    let rendered: Vec<String> =
        faults.iter().map(|fault| renderer.render(&[group(level.clone(), fault, sources)])).collect();
    rendered.join("\n\n")
}

fn group<'f>(level: Level<'f>, fault: &'f Fault, sources: &'f Sources) -> Group<'f> {
    let title = match fault.path.is_empty() {
        true => fault.message.clone(),
        false => format!("{}: {}", fault.path, fault.message),
    };
    let mut group = Group::with_title(level.primary_title(title).id(fault.code.name()));
    if let Some((source, span)) = place(fault.origin, sources) {
        let mut snippet = snippet(source).annotation(AnnotationKind::Primary.span(span));
        let (here, elsewhere): (Vec<_>, Vec<_>) =
            fault.notes.iter().partition(|note| fault.origin.is_some_and(|o| o.source == note.origin.source));
        for note in here {
            if let Some((_, span)) = place(Some(note.origin), sources) {
                let annotation = AnnotationKind::Context.span(span).label(note.message.as_str());
                snippet = snippet.annotation(annotation);
            }
        }
        group = group.element(snippet);
        for note in elsewhere {
            if let Some((source, span)) = place(Some(note.origin), sources) {
                let annotation = AnnotationKind::Context.span(span).label(note.message.as_str());
                group = group.element(self::snippet(source).annotation(annotation));
            }
        }
    }
    match &fault.help {
        Some(help) => group.element(Level::HELP.message(help.as_str())),
        None => group,
    }
}

fn snippet<'s, T: Clone>(source: &'s Source) -> Snippet<'s, T> {
    let name = match &source.name {
        SourceName::File(path) => path.display().to_string(),
        SourceName::Set => "--set".to_owned(),
    };
    Snippet::source(&*source.text).path(name)
}

/// The text and the bytes of it that are meant: at least one character, on one line, so that the mark stays short.
fn place(origin: Option<Origin>, sources: &Sources) -> Option<(&Source, Range<usize>)> {
    let origin = origin?;
    let source = sources.get(origin.source)?;
    let text = &*source.text;
    let start = text.floor_char_boundary(origin.start.min(text.len()));
    let line_end = text[start..].find('\n').map_or(text.len(), |newline| start + newline);
    let end = text.ceil_char_boundary(origin.end.clamp(start, line_end.max(start)));
    Some((source, start..end.max(start)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::document::{Document, FaultCode};
    use std::path::Path;

    const TEXT: &str = "name = \"ä\"\n[planner]\nprefered_clearance_m = 0.4 # meters\n";

    fn origin_of(document: &Document, path: &str) -> Origin {
        document.root.nearest(path).place()
    }

    #[test]
    fn a_fault_shows_its_line_with_the_place_underlined_and_the_help() {
        let (document, mut faults) = Document::from_text(Path::new("office.toml"), TEXT, &[]);
        let key = "planner.prefered_clearance_m";
        let message = "unknown key, did you mean preferred_clearance_m?";
        let fault = Fault::new(FaultCode::UnknownKey, key, origin_of(&document, key), message);
        faults.push(fault.help("see the book").note("in this section", origin_of(&document, "planner")));
        let expected = "\
error[unknown_key]: planner.prefered_clearance_m: unknown key, did you mean preferred_clearance_m?
 --> office.toml:3:1
  |
2 | [planner]
  |  ------- in this section
3 | prefered_clearance_m = 0.4 # meters
  | ^^^^^^^^^^^^^^^^^^^^
  |
  = help: see the book

1 fault";
        assert_eq!(render(&faults, &document.sources, false), expected);
        assert!(render(&faults, &document.sources, true).contains("\u{1b}["));
    }

    #[test]
    fn an_argument_is_shown_as_its_own_source_and_a_fault_without_place_as_a_title() {
        let sets = ["planner.x=0.2m".to_owned()];
        let (document, mut faults) = Document::from_text(Path::new("office.toml"), TEXT, &sets);
        faults.push(Fault::new(FaultCode::MissingPart, "", None, "the pipeline has no [world]"));
        let text = render(&faults, &document.sources, false);
        assert!(text.contains(" --> --set:1:14"), "{text}");
        assert!(text.contains("1 | planner.x=0.2m"), "{text}");
        assert!(text.contains("error[missing_part]: the pipeline has no [world]\n\n2 faults"), "{text}");
    }

    #[test]
    fn places_at_the_end_of_a_text_and_over_several_lines_are_shown() {
        let text = "a = [\n  1,\n  'x'\n]\nb = \"";
        let (document, mut faults) = Document::from_text(Path::new("a.toml"), text, &[]);
        let whole = document.root.nearest("a").origin;
        faults.push(Fault::new(FaultCode::BadValue, "a", whole, "is odd"));
        faults.push(Fault::new(
            FaultCode::BadValue,
            "b",
            Origin { start: 9_999, end: 10_005, ..whole },
            "is far",
        ));
        let text = render(&faults, &document.sources, false);
        assert!(text.contains("1 | a = [\n  |     ^"), "{text}");
        assert!(text.contains("3 faults"), "{text}");
    }
}
