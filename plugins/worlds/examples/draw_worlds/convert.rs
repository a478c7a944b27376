//! Worlds of published experiments, converted from the files in `tests/data`.

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use rumbo_kit::map_file::MapImage;

use super::Drawn;

type Converted = Result<Vec<(String, Drawn)>, Box<dyn Error>>;

/// Every converted world with its name.
pub fn all(data: &Path) -> Converted {
    let read = |name: &str| std::fs::read_to_string(data.join(name));
    let office = toml::from_str(&read("dc_office_world.toml")?)?;
    let arena = toml::from_str(&read("dc_arena_world.toml")?)?;
    let warehouse = toml::from_str(&read("fc_warehouse.toml")?)?;
    let mut worlds = vec![
        (
            "dc_office".into(),
            segments_and_boxes("office of 20 m by 20 m, after Valverde Moreno (2015)", &office)?,
        ),
        ("dc_arena".into(), segments_and_boxes("arena of 5 m by 5 m, after Valverde Moreno (2015)", &arena)?),
        ("fc_warehouse".into(), warehouse_of(&warehouse)?),
    ];
    let rubble: serde_json::Value = serde_json::from_str(&read("slam2d_sim_loop_world.json")?)?;
    worlds.extend(rubble_loops(&rubble)?);
    worlds.extend(cell_maps(&toml::from_str(&read("natural_landmark_maps.toml")?)?)?);
    Ok(worlds)
}

fn number(value: &toml::Value) -> Result<f64, Box<dyn Error>> {
    value
        .as_float()
        .or(value.as_integer().map(|n| n as f64))
        .ok_or_else(|| format!("{value} is no number").into())
}

fn numbers(value: Option<&toml::Value>) -> Result<Vec<f64>, Box<dyn Error>> {
    value.and_then(toml::Value::as_array).ok_or("no list of numbers")?.iter().map(number).collect()
}

fn tables<'a>(table: &'a toml::Table, key: &str) -> Result<&'a Vec<toml::Value>, Box<dyn Error>> {
    table.get(key).and_then(toml::Value::as_array).ok_or_else(|| format!("no {key}").into())
}

fn header(name: &str, bounds: &[f64], height_m: f64) -> String {
    format!("name = \"{name}\"\nbounds = {bounds:?}\nwall_height_m = {height_m:?}\n")
}

fn wall(text: &mut String, segment: &[f64]) -> Result<(), Box<dyn Error>> {
    let &[x0, y0, x1, y1] = segment else { return Err(format!("{segment:?} is no segment").into()) };
    Ok(write!(text, "\n[[wall]]\nfrom = [{x0:?}, {y0:?}]\nto = [{x1:?}, {y1:?}]\n")?)
}

fn solid(text: &mut String, name: &str, center: &[f64], size: &[f64]) -> Result<(), Box<dyn Error>> {
    Ok(write!(text, "\n[[box]]\nname = \"{name}\"\ncenter = {center:?}\nsize = {size:?}\n")?)
}

fn segments_and_boxes(name: &str, file: &toml::Table) -> Result<Drawn, Box<dyn Error>> {
    let world = file.get("world").and_then(toml::Value::as_table).ok_or("no world")?;
    let height_m = world.get("wall_height_m").map_or(Ok(2.0), number)?;
    let mut text = header(name, &numbers(world.get("bounds"))?, height_m);
    for segment in tables(world, "segments")? {
        wall(&mut text, &numbers(Some(segment))?)?;
    }
    for piece in tables(file, "box")? {
        let name = piece.get("name").and_then(toml::Value::as_str).unwrap_or("box");
        solid(&mut text, name, &numbers(piece.get("center"))?, &numbers(piece.get("size"))?)?;
    }
    Ok(Drawn::Toml(text))
}

/// Outlines of four segments are racks, which are solid; single segments are walls.
fn warehouse_of(file: &toml::Table) -> Result<Drawn, Box<dyn Error>> {
    let world = file.get("world").and_then(toml::Value::as_table).ok_or("no world")?;
    let mut text = header("warehouse of 40 m by 30 m with ten racks", &numbers(world.get("bounds"))?, 2.0);
    for obstacle in tables(file, "obstacle")? {
        let segments = obstacle.get("segments").and_then(toml::Value::as_array).ok_or("no segments")?;
        let segments: Vec<Vec<f64>> = segments.iter().map(|s| numbers(Some(s))).collect::<Result<_, _>>()?;
        match segments.as_slice() {
            [single] => wall(&mut text, single)?,
            outline => {
                let name = obstacle.get("name").and_then(toml::Value::as_str).unwrap_or("rack");
                let bound = |axis: usize, pick: fn(f64, f64) -> f64| {
                    outline.iter().map(|segment| segment[axis]).reduce(pick).unwrap_or(0.0)
                };
                let (low, high) = ([0, 1].map(|a| bound(a, f64::min)), [0, 1].map(|a| bound(a, f64::max)));
                let center = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
                solid(&mut text, name, &center, &[high[0] - low[0], high[1] - low[1]])?;
            }
        }
    }
    Ok(Drawn::Toml(text))
}

/// Turned boxes given by outlines stay outlines: their corners are rounded to a tenth of a millimeter.
fn rubble_loops(file: &serde_json::Value) -> Converted {
    let segments = |key: &str| -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
        Ok(serde_json::from_value(file.get(key).cloned().ok_or_else(|| format!("no {key}"))?)?)
    };
    let (base, more) = (segments("segments_base")?, segments("segments_dense_extra")?);
    let world = |name: &str, segments: &[Vec<f64>]| -> Result<Drawn, Box<dyn Error>> {
        let mut text = header(name, &[-10.0, -7.0, 10.0, 7.0], 2.0);
        segments.iter().try_for_each(|segment| wall(&mut text, segment))?;
        Ok(Drawn::Toml(text))
    };
    Ok(vec![
        ("rubble_loop".into(), world("a loop around a block, with rubble", &base)?),
        (
            "rubble_loop_dense".into(),
            world("a loop around a block, with much rubble", &[base, more].concat())?,
        ),
    ])
}

fn cell_maps(file: &toml::Table) -> Converted {
    tables(file, "map")?.iter().map(cell_map).collect()
}

/// Rectangles of cells, line 0 at the top.
fn cell_map(map: &toml::Value) -> Result<(String, Drawn), Box<dyn Error>> {
    let value = |key: &str| map.get(key).ok_or_else(|| format!("no {key}"));
    let count = |key: &str| -> Result<usize, Box<dyn Error>> { Ok(number(value(key)?)? as usize) };
    let (width, height) = (count("columns")?, count("lines")?);
    let mut cells = vec![0; width * height];
    for rectangle in value("rectangles")?.as_array().ok_or("no rectangles")? {
        let rectangle: Vec<usize> = numbers(Some(rectangle))?.into_iter().map(|n| n as usize).collect();
        let &[line, column, n_lines, n_columns, occupied] = rectangle.as_slice() else {
            return Err(format!("{rectangle:?} is no rectangle").into());
        };
        for row in (line..line + n_lines).map(|line| height - 1 - line) {
            cells[row * width + column..row * width + column + n_columns].fill(if occupied == 1 {
                100
            } else {
                0
            });
        }
    }
    let name = value("name")?.as_str().ok_or("the name is no text")?;
    let image =
        MapImage { width, height, resolution_m: number(value("cell_size_m")?)?, origin: [0.0; 3], cells };
    Ok((format!("natural_landmark_{name}"), Drawn::Map(image)))
}
