use super::*;
use crate::document::Document;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Something with every shape that parameters have.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Params {
    stop_distance_m: f64,
    weights: Vec<f64>,
    pair: [f64; 2],
    limit: Option<f64>,
    count: u32,
    label: String,
    flag: bool,
    mode: Mode,
    style: Option<Style>,
    place: Place,
    start: Start,
    list: Vec<Place>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum Mode {
    #[default]
    Slow,
    VeryFast,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Style {
    /// Round.
    Disc { radius_m: f64 },
    /// Straight.
    Box { width_m: f64, length_m: f64 },
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct Place {
    x_m: f64,
    y_m: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
enum Start {
    Word(Mode),
    Place { x_m: f64, y_m: f64 },
}

impl Default for Start {
    fn default() -> Self {
        Start::Word(Mode::Slow)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Strict {
    name: String,
    size_m: f64,
    #[serde(default)]
    extra: Option<String>,
}

fn parse<T: DeserializeOwned + JsonSchema>(text: &str) -> (Option<Parsed<T>>, Vec<String>) {
    let (document, mut faults) = Document::from_text(Path::new("a.toml"), &format!("[p]\n{text}"), &[]);
    let parsed = parse_table(document.root.nearest("p"), "p", &mut faults);
    faults.sort();
    let lines = faults.lines(&document.sources);
    (parsed, lines)
}

#[test]
fn a_good_table_is_a_struct() {
    let text = "stop_distance_m = 1\nweights = [1, 2.5]\npair = [1.0, 2.0]\nlimit = 3.0\ncount = 4\n\
        label = 'x'\nflag = true\nmode = 'very_fast'\nstyle = { kind = 'box', width_m = 1.0, length_m = 2 }\n\
        place = { x_m = 1.0 }\nstart = { x_m = 1.0, y_m = 2.0 }\nlist = [{ y_m = 1.0 }]";
    let (parsed, lines) = parse::<Params>(text);
    assert_eq!(lines, Vec::<String>::new());
    let parsed = parsed.unwrap();
    assert_eq!(parsed.value, toml::from_str(text).unwrap());
    assert!(parsed.left_out.is_empty());
}

#[test]
fn all_faults_of_a_table_come_at_once_each_at_its_place() {
    let text = "stop_distance = 1.0\nweights = [1.0, 'x', 2.0, true]\npair = [1.0]\nlimit = 'no'\ncount = -1\n\
        label = 5\nflag = 1\nmode = 'very_fats'\nstyle = { kind = 'dics', radius_m = 1.0 }\n\
        place = { x = 1.0, y_m = 'up' }\nstart = 4\nlist = [{ y_m = 1.0 }, 7]";
    let (parsed, lines) = parse::<Params>(text);
    assert_eq!(
        lines,
        [
            "a.toml:2:1 p.stop_distance: unknown key, units are in the key: stop_distance_m",
            "a.toml:3:17 p.weights[1]: is \"x\", expected a number",
            "a.toml:3:27 p.weights[3]: is true, expected a number",
            "a.toml:4:8 p.pair: has 1 items, expected 2",
            "a.toml:5:9 p.limit: is \"no\", expected a number",
            "a.toml:6:9 p.count: is -1, expected at least 0",
            "a.toml:7:9 p.label: is 5, expected text in quotes",
            "a.toml:8:8 p.flag: is 1, expected true or false",
            "a.toml:9:8 p.mode: is \"very_fats\", did you mean very_fast?",
            "a.toml:10:18 p.style.kind: is \"dics\", did you mean disc?",
            "a.toml:11:11 p.place.x: unknown key, units are in the key: x_m",
            "a.toml:11:26 p.place.y_m: is \"up\", expected a number",
            "a.toml:12:9 p.start: is 4, expected \"slow\" or \"very_fast\" or a table",
            "a.toml:13:24 p.list[1]: is 7, expected a table",
        ]
    );
    assert_eq!(parsed.unwrap().value, Params::default(), "what is wrong has its default");
}

#[test]
fn keys_that_must_be_there_are_all_named() {
    let (parsed, lines) = parse::<Strict>("extra = 'x'");
    assert_eq!(parsed, None);
    assert_eq!(
        lines,
        [
            "a.toml:1:2 p.name: is missing, expected text in quotes",
            "a.toml:1:2 p.size_m: is missing, expected a number",
        ]
    );
    let (_, lines) = parse::<Params>("style = { kind = 'box', width_m = 1.0 }");
    assert_eq!(lines, ["a.toml:2:1 p.style.length_m: is missing, expected a number"]);
    let (_, lines) = parse::<Params>("style = { width_m = 1.0 }");
    assert_eq!(lines, ["a.toml:2:1 p.style.kind: is missing, expected one of disc, box"]);
}

#[test]
fn a_wrong_value_leaves_the_others_as_they_are() {
    let (parsed, lines) = parse::<Params>("stop_distance_m = 'far'\ncount = 3\nlimit = nan");
    let parsed = parsed.unwrap();
    assert_eq!((parsed.value.count, parsed.value.stop_distance_m), (3, 0.0));
    assert_eq!(parsed.left_out, ["stop_distance_m", "limit"]);
    assert_eq!(lines.len(), 2, "{lines:#?}");
}

#[test]
fn what_the_schema_does_not_know_the_parser_reports() {
    let (document, mut faults) =
        Document::from_text(Path::new("a.toml"), "[p]\na = 1\nb = [2, 3]\nc = 4", &[]);
    let parsed =
        parse_with(
            document.root.nearest("p"),
            "p",
            &Value::Bool(true),
            &[],
            &mut faults,
            |table| match table.keys().find(|key| *key != "c") {
                Some(key) if key == "b" => Err(ParseFault { path: "b[1]".into(), message: "no b".into() }),
                Some(key) => Err(ParseFault { path: key.clone(), message: "neither".into() }),
                None => Ok(table.len()),
            },
        );
    assert_eq!(parsed, Some(Parsed { value: 1, left_out: vec!["a".into(), "b".into()] }));
    assert_eq!(faults.lines(&document.sources), ["a.toml:2:5 p.a: neither", "a.toml:3:9 p.b[1]: no b"]);
}

#[test]
fn a_value_in_place_of_a_table_is_said_so() {
    let (document, mut faults) = Document::from_text(Path::new("a.toml"), "p = 3", &[]);
    assert_eq!(parse_table::<Params>(document.root.nearest("p"), "p", &mut faults), None);
    assert_eq!(faults.lines(&document.sources), ["a.toml:1:5 p: is 3, expected a table"]);
}
