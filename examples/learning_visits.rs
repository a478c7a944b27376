//! What several visits teach a map: the figures of `docs/natural-landmarks.md`, "A map that learns".
//!
//! `cargo run --release --example learning_visits -- [office|laboratory] [N_DRAWS] [N_STARTS]`. For each draw a fifth of the
//! furniture stands elsewhere: after one visit to the place as it was mapped come five to the place as it is now, each with
//! one person who walks about. Counted are cells at surfaces of moved furniture that a laser without noise meets on the
//! robot's way, cells of the map where furniture stood that is gone, walls that the furniture hid when the map was made, and
//! changes elsewhere. Then a robot is put down at places of the changed world and must find itself, on the old map and on the
//! one that has learned.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{EndReason, Engine, Metrics, Observer, StepView};
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::messages::Data;
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Registry;
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::GridSize;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, PictureFormat, SavedAs, load_map, save_map};
use rumbo_kit::ray::{Ray, RayGrid};
use rumbo_kit::world_file::{SolidBox, WorldScene, draw_mapped, load_world};
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

type Fallible<T = ()> = Result<T, Box<dyn Error>>;

const VISIT: &str = "pipelines/learning_visit.toml";
const N_VISITS: usize = 5;
/// Found within this, meters.
const FOUND_M: f64 = 0.1;
/// A surface cell counts when a laser without noise meets it in so many scans of a visit.
const SEEN_SCANS: u32 = 20;
/// Moved furniture keeps this distance from the robot's way points, meters.
const OFF_WAY_M: f64 = 0.6;

struct Place {
    world: &'static str,
    map: &'static str,
    start: [f64; 3],
    /// None for those of the pipeline.
    waypoints: Option<&'static [[f64; 2]]>,
    /// Where somebody walks to and fro, one way a visit.
    walks: &'static [[[f64; 2]; 2]],
}

const OFFICE: Place = Place {
    world: "pipelines/worlds/natural_landmark_10x10.toml",
    map: "pipelines/worlds/natural_landmark_10x10.yaml",
    start: [1.5, 8.5, 30.0],
    waypoints: None,
    walks: &[
        [[0.5, 7.6], [0.5, 10.2]],
        [[3.1, 7.7], [3.1, 10.0]],
        [[3.1, 4.8], [3.1, 1.9]],
        [[6.9, 4.8], [6.9, 1.0]],
        [[10.4, 4.9], [10.4, 3.0]],
    ],
};

const LABORATORY: Place = Place {
    world: "pipelines/worlds/laboratory.toml",
    map: "pipelines/worlds/laboratory-map.yaml",
    start: [3.9, 1.3, 90.0],
    waypoints: Some(&[
        [3.9, 2.4],
        [2.0, 1.4],
        [2.0, 4.2],
        [2.45, 6.1],
        [1.75, 6.75],
        [3.4, 7.9],
        [4.4, 6.3],
        [5.2, 7.9],
        [7.0, 6.3],
        [7.0, 7.4],
        [7.0, 4.4],
        [6.4, 1.9],
        [6.4, 3.4],
        [4.8, 2.9],
        [3.9, 3.2],
    ]),
    walks: &[
        [[7.7, 2.7], [7.7, 3.9]],
        [[2.6, 8.5], [3.3, 8.5]],
        [[5.5, 8.5], [6.1, 8.5]],
        [[7.7, 2.7], [7.7, 3.9]],
        [[2.6, 8.5], [3.3, 8.5]],
    ],
};

fn main() -> Fallible {
    let mut arguments = std::env::args().skip(1);
    let place = match arguments.next().as_deref() {
        None | Some("office") => OFFICE,
        Some("laboratory") => LABORATORY,
        Some(other) => return Err(format!("no place `{other}`: office or laboratory").into()),
    };
    let n_draws: u64 = arguments.next().map_or(Ok(3), |text| text.parse())?;
    let n_starts: usize = arguments.next().map_or(Ok(30), |text| text.parse())?;
    let registry = rumbo::registry()?;
    let folder = std::env::temp_dir().join(format!("rumbo-learning-visits-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let done = (1..=n_draws).try_for_each(|draw| study(&place, draw, n_starts, &folder, &registry));
    std::fs::remove_dir_all(&folder)?;
    done
}

fn study(place: &Place, draw: u64, n_starts: usize, folder: &Path, registry: &Registry) -> Fallible {
    let mut rng = stream(draw, "learning_visits");
    let scene = load_world(Path::new(place.world))?;
    let before = load_map(Path::new(place.map), DEFAULT_MAX_CELLS)?;
    let moved = Moved::draw(&scene, &place.stops(registry)?, &mut rng);
    let truth = moved.truth(&scene, &before);
    println!("draw {draw}: {}", moved.to_string_list());
    let mut map = PathBuf::from(place.map).canonicalize()?;
    let mut memory = None;
    let mut seen = vec![0; truth.cells.len()];
    for visit in 0..=N_VISITS {
        let things = if visit == 0 { Moved::default() } else { moved.clone() };
        let walk = place.walks.get(visit.saturating_sub(1)).or(place.walks.first()).ok_or("nobody walks")?;
        let sets = place.sets(&things, Some(walk), &map, memory.as_deref(), draw * 100 + visit as u64);
        let mut watch = Watch { rays: rays(&truth), image: &truth, seen: vec![0; truth.cells.len()] };
        let visited = drive(Path::new(VISIT), &sets, registry, &mut watch)?;
        if visit > 0 {
            seen.iter_mut().zip(&watch.seen).for_each(|(most, n)| *most = (*most).max(*n));
        }
        let saved = visited.engine.save_map()?;
        let grid = saved.map.grid.as_ref().ok_or("no grid")?;
        let image = MapImage::of_grid(grid, SavedAs::Trinary).ok_or("an empty map")?;
        map = folder.join(format!("map-{draw}-{visit}.yaml"));
        save_map(&map, &image, SavedAs::Trinary, PictureFormat::Png)?;
        let (_, bytes) = saved.kept.first().ok_or("nothing is remembered")?;
        let file = folder.join(format!("memory-{draw}-{visit}"));
        std::fs::write(&file, bytes)?;
        memory = Some(file);
        let figures = Figures::of(&before, &image, &moved, &scene, &seen);
        println!("  visit {visit} ({}, {} contacts): {figures}", visited.reason, visited.contacts);
    }
    let starts = starts(&truth, n_starts, &mut rng);
    for (name, map) in [("old map", PathBuf::from(place.map).canonicalize()?), ("map that has learned", map)]
    {
        let cache = folder.join(format!("model-{draw}-{}", name.len()));
        let mut n_found = 0;
        let mut n_wrong = 0;
        for (k, start) in starts.iter().enumerate() {
            let mut sets = place.world_sets(&moved, None, k as u64 + 1);
            sets.push(format!(
                "world.start={{ x_m = {}, y_m = {}, yaw_deg = {} }}",
                start[0], start[1], start[2]
            ));
            sets.push(format!("map_builder.file={:?}", map.display().to_string()));
            sets.push(format!("relocalizer.cache_file={:?}", cache.display().to_string()));
            let mut silent = Metrics::new();
            let end = drive(Path::new("pipelines/landmark_global.toml"), &sets, registry, &mut silent)?;
            let is_found = end.is_tracking && end.error_m.is_some_and(|error| error <= FOUND_M);
            n_found += usize::from(is_found);
            n_wrong += usize::from(end.is_tracking && !is_found);
        }
        println!("  {name}: found {n_found} of {n_starts}, put at a wrong place {n_wrong}");
    }
    Ok(())
}

/// Furniture that stands elsewhere.
#[derive(Clone, Default)]
struct Moved {
    without: Vec<SolidBox>,
    boxes: Vec<SolidBox>,
}

fn unit(rng: &mut Rng) -> f64 {
    use rumbo_core::rng::RngExt as _;
    rng.random::<f64>()
}

/// Points of a box, five centimeters apart, and its corners.
fn points(solid: &SolidBox) -> Vec<[f64; 2]> {
    let n = |length_m: f64| (length_m / 0.05).ceil() as usize;
    let (sin, cos) = solid.yaw_rad.sin_cos();
    let at = |share: f64, other: f64| {
        let (x, y) = ((share - 0.5) * solid.size[0], (other - 0.5) * solid.size[1]);
        [solid.center[0] + cos * x - sin * y, solid.center[1] + sin * x + cos * y]
    };
    let (n_x, n_y) = (n(solid.size[0]), n(solid.size[1]));
    (0..=n_x)
        .flat_map(|i| (0..=n_y).map(move |k| (i, k)))
        .map(|(i, k)| at(i as f64 / n_x as f64, k as f64 / n_y as f64))
        .collect()
}

fn is_in(solid: &SolidBox, [x, y]: [f64; 2], margin_m: f64) -> bool {
    let (sin, cos) = solid.yaw_rad.sin_cos();
    let (dx, dy) = (x - solid.center[0], y - solid.center[1]);
    let (along, across) = (cos * dx + sin * dy, cos * dy - sin * dx);
    along.abs() <= solid.size[0] / 2.0 + margin_m && across.abs() <= solid.size[1] / 2.0 + margin_m
}

impl Moved {
    /// A fifth of the furniture, moved by 0.3 to 1 m and turned by up to 30 degrees to where nothing else is.
    fn draw(scene: &WorldScene, stops: &[[f64; 2]], rng: &mut Rng) -> Moved {
        let mut left: Vec<&SolidBox> =
            scene.boxes.iter().filter(|solid| !solid.name.starts_with("wall")).collect();
        let n = (0.2 * left.len() as f64).round() as usize;
        let mut moved = Moved::default();
        while moved.boxes.len() < n && !left.is_empty() {
            let piece = left.swap_remove((unit(rng) * left.len() as f64) as usize % left.len());
            let fits = |solid: &SolidBox, moved: &Moved| {
                let others = scene.boxes.iter().filter(|other| other.name != piece.name).chain(&moved.boxes);
                let inner = points(solid);
                let is_free =
                    others.into_iter().all(|other| !inner.iter().any(|point| is_in(other, *point, 0.05)));
                let bounds = [
                    scene.boxes.iter().map(|s| s.center[0]).fold(0.0, f64::max),
                    scene.boxes.iter().map(|s| s.center[1]).fold(0.0, f64::max),
                ];
                let is_inside =
                    inner.iter().all(|[x, y]| *x > 0.0 && *y > 0.0 && *x < bounds[0] && *y < bounds[1]);
                is_free && is_inside && stops.iter().all(|stop| !is_in(solid, *stop, OFF_WAY_M))
            };
            let found = (0..40).find_map(|_| {
                let (angle, way_m) = (TAU * unit(rng), 0.3 + 0.7 * unit(rng));
                let center = [piece.center[0] + way_m * angle.cos(), piece.center[1] + way_m * angle.sin()];
                let yaw_rad = piece.yaw_rad + (unit(rng) - 0.5) * TAU / 6.0;
                let solid =
                    SolidBox { name: format!("{}, moved", piece.name), center, yaw_rad, ..piece.clone() };
                fits(&solid, &moved).then_some(solid)
            });
            if let Some(solid) = found {
                moved.boxes.push(solid);
                moved.without.push(piece.clone());
            }
        }
        moved
    }

    /// The world as it is now, in the cells of the map.
    fn truth(&self, scene: &WorldScene, like: &MapImage) -> MapImage {
        let mut now =
            WorldScene { boxes: scene.boxes.clone(), walls: scene.walls.clone(), ..WorldScene::default() };
        self.without.iter().for_each(|piece| {
            now.remove(&piece.name);
        });
        now.boxes.extend(self.boxes.iter().cloned());
        let mut image = MapImage { cells: vec![0; like.cells.len()], ..*like };
        draw_mapped(&now, &mut image);
        image
    }

    fn to_string_list(&self) -> String {
        let name =
            |solid: &SolidBox| format!("{} at ({:.2}, {:.2})", solid.name, solid.center[0], solid.center[1]);
        self.boxes.iter().map(name).collect::<Vec<_>>().join("; ")
    }
}

impl Place {
    /// Where the robot comes by.
    fn stops(&self, registry: &Registry) -> Fallible<Vec<[f64; 2]>> {
        let sets = self.sets(&Moved::default(), None, &Path::new(self.map).canonicalize()?, None, 1);
        let loaded = Loaded::read(Path::new(VISIT), &sets, registry);
        let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
        let [x, y, _] = self.start;
        let stops = pipeline.mission.waypoints.iter().map(|waypoint| [waypoint.x_m, waypoint.y_m]);
        Ok(stops.chain([[x, y]]).collect())
    }

    /// What stands and walks in the world.
    fn world_sets(&self, moved: &Moved, walk: Option<&[[f64; 2]; 2]>, seed: u64) -> Vec<String> {
        let world = Path::new(self.world).canonicalize().unwrap_or_default();
        let boxes = moved.boxes.iter().map(|solid| {
            let ([x, y], [length, width], yaw_deg) = (solid.center, solid.size, solid.yaw_rad.to_degrees());
            format!("{{ name = {:?}, center = [{x:?}, {y:?}], size = [{length:?}, {width:?}], yaw_deg = {yaw_deg:?} }}", solid.name)
        });
        let boxes = boxes.collect::<Vec<_>>().join(", ");
        let mut things = format!("box = [{boxes}]");
        if let Some([from, to]) = walk {
            let _ = write!(
                things,
                ", person = [{{ name = \"walker\", route = [{from:?}, {to:?}], speed_m_s = 0.6, shape = \"legs\" }}]"
            );
        }
        let without: Vec<&String> = moved.without.iter().map(|piece| &piece.name).collect();
        vec![
            format!("seed={seed}"),
            format!("world.map={:?}", world.display().to_string()),
            format!("world.without={without:?}"),
            format!("world.add={{ {things} }}"),
        ]
    }

    fn sets(
        &self,
        moved: &Moved,
        walk: Option<&[[f64; 2]; 2]>,
        map: &Path,
        memory: Option<&Path>,
        seed: u64,
    ) -> Vec<String> {
        let mut sets = self.world_sets(moved, walk, seed);
        let [x, y, yaw] = self.start;
        sets.push(format!("world.start={{ x_m = {x}, y_m = {y}, yaw_deg = {yaw} }}"));
        sets.push(format!("map_builder.floor.file={:?}", map.display().to_string()));
        sets.push("map_builder.changes.removes=\"seen_before\"".to_owned());
        sets.extend(
            memory.map(|file| format!("map_builder.changes.memory={:?}", file.display().to_string())),
        );
        if let Some(waypoints) = self.waypoints {
            let list =
                waypoints.iter().map(|[x, y]| format!("{{ x_m = {x}, y_m = {y} }}")).collect::<Vec<_>>();
            sets.push(format!("mission.waypoints=[{}]", list.join(", ")));
        }
        sets
    }
}

struct Driven {
    engine: Engine,
    reason: EndReason,
    contacts: u32,
    is_tracking: bool,
    error_m: Option<f64>,
}

fn drive(
    pipeline: &Path,
    sets: &[String],
    registry: &Registry,
    watch: &mut dyn Observer,
) -> Fallible<Driven> {
    let loaded = Loaded::read(pipeline, sets, registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut engine = Engine::build(pipeline)?;
    let mut metrics = Metrics::new();
    let end = engine.run(&mut [&mut metrics, watch], &AtomicBool::new(false));
    let summary = metrics.summary(end.reason, end.detail.clone());
    let is_tracking = engine.view().estimate.status == rumbo_core::messages::Status::Tracking;
    Ok(Driven {
        engine,
        reason: end.reason,
        contacts: summary.contacts.unwrap_or(0),
        is_tracking,
        error_m: summary.final_error_m,
    })
}

fn rays(image: &MapImage) -> RayGrid {
    let occupied: Vec<u8> = image.cells.iter().map(|percent| u8::from(*percent > 50)).collect();
    RayGrid::new(GridSize::new(image.width, image.height), &occupied)
}

/// Counts scans in which a laser without noise meets a cell.
struct Watch<'a> {
    rays: RayGrid,
    image: &'a MapImage,
    seen: Vec<u32>,
}

impl Observer for Watch<'_> {
    fn on_step(&mut self, view: &StepView<'_>) {
        let n_scans = view.observations.iter().filter(|o| matches!(o.data, Data::LaserScan(_))).count();
        let Some(truth) = view.truth.filter(|_| n_scans > 0) else { return };
        let pose: Pose2 = flatten(&truth.map_from_base);
        let [x0, y0, _] = self.image.origin;
        let resolution_m = self.image.resolution_m;
        let [x, y] = [(pose.translation.x - x0) / resolution_m, (pose.translation.y - y0) / resolution_m];
        let reach = 8.0 / resolution_m;
        let mut met: Vec<usize> = (0..361)
            .filter_map(|k| {
                let angle = pose.rotation.angle() + (f64::from(k) * 0.5 - 90.0).to_radians();
                let range = self.rays.cast(&Ray::at_angle(x, y, angle), reach) + 1e-6;
                let (col, row) = (x + range * angle.cos(), y + range * angle.sin());
                let is_met = range < reach && col >= 0.0 && row >= 0.0;
                let (col, row) = (col as usize, row as usize);
                (is_met && col < self.image.width && row < self.image.height)
                    .then(|| row * self.image.width + col)
            })
            .collect();
        met.sort_unstable();
        met.dedup();
        met.into_iter().for_each(|cell| self.seen[cell] += 1);
    }
}

/// Counts of cells.
#[derive(Default)]
struct Figures {
    n_new: usize,
    n_visible: usize,
    n_near: usize,
    n_gone: usize,
    n_stood: usize,
    /// Walls that came in because what hid them when the map was made has gone.
    n_uncovered: usize,
    n_false: usize,
}

impl Figures {
    fn of(before: &MapImage, after: &MapImage, moved: &Moved, scene: &WorldScene, seen: &[u32]) -> Figures {
        let size = GridSize::new(before.width, before.height);
        let margin_m = 1.5 * before.resolution_m;
        let own_m = before.resolution_m;
        let at = |cell: usize| {
            let (col, row) = size.col_row(cell);
            let meters = |n: usize, origin: f64| origin + (n as f64 + 0.5) * before.resolution_m;
            [meters(col, before.origin[0]), meters(row, before.origin[1])]
        };
        let is_set = |image: &MapImage, cell: usize| {
            let [x, y] = at(cell);
            let col = ((x - image.origin[0]) / image.resolution_m).floor();
            let row = ((y - image.origin[1]) / image.resolution_m).floor();
            col >= 0.0 && row >= 0.0 && image.is_occupied(col as usize, row as usize)
        };
        let beside_set = |image: &MapImage, cell: usize| {
            (-1..=1).any(|d_col| {
                (-1..=1)
                    .any(|d_row| size.neighbor(cell, d_col, d_row).is_some_and(|cell| is_set(image, cell)))
            })
        };
        let walls = |point: [f64; 2]| {
            scene
                .boxes
                .iter()
                .filter(|solid| !moved.without.iter().any(|gone| gone.name == solid.name))
                .any(|solid| is_in(solid, point, own_m))
        };
        let mut figures =
            Figures { n_new: 0, n_visible: 0, n_near: 0, n_gone: 0, n_stood: 0, ..Figures::default() };
        for (cell, n_scans) in seen.iter().enumerate() {
            let point = at(cell);
            let is_new = moved.boxes.iter().any(|solid| is_in(solid, point, own_m));
            let is_old = moved.without.iter().any(|solid| is_in(solid, point, own_m));
            if is_new && !walls(point) && *n_scans >= SEEN_SCANS {
                figures.n_visible += 1;
                figures.n_new += usize::from(is_set(after, cell));
                figures.n_near += usize::from(beside_set(after, cell));
            }
            if is_old && !is_new && !walls(point) && is_set(before, cell) {
                figures.n_stood += 1;
                figures.n_gone += usize::from(!is_set(after, cell));
            }
            let is_own = moved.boxes.iter().chain(&moved.without).any(|solid| is_in(solid, point, margin_m));
            let is_changed = !is_own && is_set(before, cell) != is_set(after, cell);
            // A thicker wall would be none of these: it stands on the old map, in the cell beside.
            let is_uncovered = is_changed && walls(point) && !beside_set(before, cell);
            figures.n_uncovered += usize::from(is_uncovered);
            figures.n_false += usize::from(is_changed && !is_uncovered);
        }
        figures
    }
}

impl std::fmt::Display for Figures {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Figures { n_new, n_visible, n_near, n_gone, n_stood, n_uncovered, n_false } = self;
        write!(
            f,
            "came in {n_new} of {n_visible} ({n_near} within a cell), gone {n_gone} of {n_stood}, walls that were hidden {n_uncovered}, changed elsewhere {n_false}"
        )
    }
}

/// Places at least half a meter from everything, with a heading.
fn starts(truth: &MapImage, n: usize, rng: &mut Rng) -> Vec<[f64; 3]> {
    let size = GridSize::new(truth.width, truth.height);
    let occupied: Vec<u8> = truth.cells.iter().map(|percent| u8::from(*percent > 50)).collect();
    let field = squared_distance_field(size, &occupied);
    let keep = (0.5 / truth.resolution_m).powi(2);
    let free: Vec<usize> = (0..size.n_cells())
        .filter(|cell| f64::from(field[*cell]) >= keep && is_enclosed(size, *cell, &occupied))
        .collect();
    let draw = |_| {
        let (col, row) = size.col_row(free[(unit(rng) * free.len() as f64) as usize % free.len()]);
        let place = |n: usize, origin: f64, share: f64| origin + (n as f64 + share) * truth.resolution_m;
        [
            place(col, truth.origin[0], unit(rng)),
            place(row, truth.origin[1], unit(rng)),
            360.0 * unit(rng) - 180.0,
        ]
    };
    (0..n).map(draw).collect()
}

/// Walls stand on all four sides of it.
fn is_enclosed(size: GridSize, cell: usize, occupied: &[u8]) -> bool {
    let (col, row) = size.col_row(cell);
    let is_set = |col: usize, row: usize| occupied[size.index(col, row)] != 0;
    (0..col).any(|c| is_set(c, row))
        && (col..size.width).any(|c| is_set(c, row))
        && (0..row).any(|r| is_set(col, r))
        && (row..size.height).any(|r| is_set(col, r))
}
