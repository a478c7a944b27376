//! A world file made ready: walls and solids in one lattice frame, sorted once for each height that is looked at.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::robot::Hull;
use rumbo_kit::map_file::MapImage;
use rumbo_kit::world_file::{Door, Material, WorldMark, WorldScene};

use super::hardships::Wheels;
use super::lattice::Lattice;
use super::params::Companion;
use super::solid::{Footprint, Point, Solid, Vector};
use super::terrain::Terrain;
use super::walker::Walker;

/// What must be seen: which heights, and whether glass counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Lowest height, meters.
    pub z_min_m: f64,
    /// Largest height, meters.
    pub z_max_m: f64,
    /// Glass counts.
    pub with_glass: bool,
}

impl View {
    /// Everything opaque.
    pub const ALL_HEIGHTS: Self =
        Self { z_min_m: f64::NEG_INFINITY, z_max_m: f64::INFINITY, with_glass: false };
}

/// The surroundings of the robot.
#[derive(Debug)]
pub struct Place {
    /// Edge of a lattice cell.
    pub resolution_m: f64,
    /// From the map's frame to the lattice's, both in meters.
    pub lattice_from_map: Pose2,
    /// Raised floor.
    pub terrain: Terrain,
    /// Edges of raised floor that stop the robot, in cells.
    pub barriers: Vec<Footprint>,
    /// Identified marks.
    pub marks: Vec<WorldMark>,
    /// Who walks in front of the robot.
    pub companion: Option<Companion>,
    /// What careful people keep away from.
    pub hull: Option<Hull>,
    size: (usize, usize),
    walls: Vec<bool>,
    wall_height_m: f64,
    solids: Vec<Solid>,
    walkers: Vec<Walker>,
    doors: Vec<Door>,
    movers: Vec<Solid>,
    views: Vec<(View, usize)>,
    lattices: Vec<(Members, Lattice)>,
}

/// Which things are in a lattice: two views of the same things share it.
#[derive(Debug, Clone, PartialEq)]
struct Members {
    walls: bool,
    solids: Vec<u32>,
}

/// As tall as people are by default.
const COMPANION_HEIGHT_M: f64 = 1.8;
/// A world without a background map gets at most this many cells along its longer side.
const MOST_CELLS: f64 = 400.0;
const FINEST_CELL_M: f64 = 0.05;

/// How large a lattice must be to hold a scene and its map.
pub struct Extent {
    /// Edge of a cell.
    resolution_m: f64,
    /// Cells left of and below the map's first one.
    before: [f64; 2],
    /// Cells along both axes.
    n_cells: [f64; 2],
}

impl Extent {
    /// Of a scene with its background map, if it has one.
    pub fn of(scene: &WorldScene, map: Option<&MapImage>) -> Extent {
        let map_from_lattice =
            map.map_or(Pose2::identity(), |map| pose2(map.origin[0], map.origin[1], map.origin[2]));
        let in_lattice = footprints(scene, &map_from_lattice.inverse());
        let reach = |pick: fn(f64, f64) -> f64, start: [f64; 2], side: f64| {
            in_lattice.iter().fold(start, |bound, (footprint, _)| {
                let (center, radius) = footprint.bounding_disc();
                [pick(bound[0], center.x + side * radius), pick(bound[1], center.y + side * radius)]
            })
        };
        let (low, high) = match map {
            Some(map) => {
                ([0.0; 2], [map.width as f64 * map.resolution_m, map.height as f64 * map.resolution_m])
            }
            None => ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]),
        };
        let (low, high) = match reach(f64::min, low, -1.0) {
            low if low[0].is_finite() => (low, reach(f64::max, high, 1.0)),
            // Nothing but bounds: an empty hall.
            _ => ([0.0; 2], [1.0; 2]),
        };
        let resolution_m = map.map_or_else(
            || ((high[0] - low[0]).max(high[1] - low[1]) / MOST_CELLS).max(FINEST_CELL_M),
            |map| map.resolution_m,
        );
        // The map's own cells stay where they are; without a map a cell of air surrounds everything.
        let air = if map.is_some() { 0.0 } else { 1.0 };
        let before = low.map(|low| air - (low / resolution_m).floor());
        let n_cells = [0, 1].map(|axis| (high[axis] / resolution_m - 1e-9).ceil() + before[axis] + air);
        Extent { resolution_m, before, n_cells }
    }

    /// Cells of the whole lattice; more than fit into memory where things lie far apart.
    pub fn area(&self) -> f64 {
        self.n_cells[0] * self.n_cells[1]
    }
}

impl Place {
    /// Prepares a scene with its background map, if it has one.
    pub fn new(scene: &WorldScene, map: Option<&MapImage>) -> Self {
        let map_from_lattice =
            map.map_or(Pose2::identity(), |map| pose2(map.origin[0], map.origin[1], map.origin[2]));
        let Extent { resolution_m, before, n_cells } = Extent::of(scene, map);
        let size = n_cells.map(|n| n as usize);
        let shift = pose2(-before[0] * resolution_m, -before[1] * resolution_m, 0.0);
        let lattice_from_map = (map_from_lattice * shift).inverse();
        let mut place = Self {
            resolution_m,
            lattice_from_map,
            terrain: Terrain::new(scene, &lattice_from_map, resolution_m),
            barriers: Vec::new(),
            marks: scene.marks.clone(),
            companion: None,
            hull: None,
            size: (size[0], size[1]),
            walls: vec![false; if map.is_some() { size[0] * size[1] } else { 0 }],
            wall_height_m: scene.map_height_m,
            solids: Vec::new(),
            walkers: scene.persons.iter().cloned().map(Walker::new).collect(),
            doors: scene.doors.clone(),
            movers: Vec::with_capacity(scene.doors.len() + 2 * scene.persons.len()),
            views: Vec::new(),
            lattices: Vec::new(),
        };
        if let Some(map) = map {
            let offset = before[1] as usize * size[0] + before[0] as usize;
            for (row, cells) in map.cells.chunks_exact(map.width).enumerate() {
                for (col, &cell) in cells.iter().enumerate() {
                    place.walls[offset + row * size[0] + col] = cell > 50;
                }
            }
        }
        place.solids = footprints(scene, &lattice_from_map)
            .into_iter()
            .map(|(footprint, (z_min_m, z_max_m, material))| {
                place.in_cells(footprint, z_min_m, z_max_m, material)
            })
            .collect();
        place.set_time(0.0, &Pose2::identity());
        place
    }

    /// Raised floor stops wheels like these where it is too high or too steep.
    pub fn bar(&mut self, wheels: &Wheels) {
        let barriers = self.terrain.barriers(wheels.max_step_m, wheels.max_slope_deg.to_radians());
        let in_cells = |point: Point| self.cells_from_map(point);
        self.barriers = barriers
            .iter()
            .map(|[from, to]| Footprint::Segment { from: in_cells(*from), to: in_cells(*to) })
            .collect();
    }

    /// What a sensor at a height must look at: on raised floor everything, as the height changes all the time.
    pub fn view_at(&self, z_m: f64, with_glass: bool) -> View {
        if self.terrain.is_flat() {
            View { z_min_m: z_m, z_max_m: z_m, with_glass }
        } else {
            View { with_glass, ..View::ALL_HEIGHTS }
        }
    }

    /// A solid given in the lattice frame in meters.
    fn in_cells(&self, footprint: Footprint, z_min_m: f64, z_max_m: f64, material: Material) -> Solid {
        let scale = 1.0 / self.resolution_m;
        let footprint = match footprint {
            Footprint::Segment { from, to } => Footprint::Segment { from: from * scale, to: to * scale },
            Footprint::Disc { center, radius } => {
                Footprint::Disc { center: center * scale, radius: radius * scale }
            }
            Footprint::Rectangle { center, axis, half } => {
                Footprint::Rectangle { center: center * scale, axis, half: half * scale }
            }
        };
        Solid {
            footprint,
            z_min: z_min_m * scale,
            z_max: z_max_m * scale,
            is_glass: material == Material::Glass,
        }
    }

    /// A point of the map in cells of the lattice.
    pub fn cells_from_map(&self, point: Point) -> Point {
        (self.lattice_from_map * point) / self.resolution_m
    }

    /// Where the person of this name is, in the map.
    pub fn person(&self, name: &str) -> Option<Point> {
        self.walkers.iter().find(|walker| walker.name() == name).map(Walker::center)
    }

    /// Moves people and doors to where they are at a time, with the robot at `map_from_base`.
    pub fn set_time(&mut self, time_s: f64, map_from_base: &Pose2) {
        let mut movers = std::mem::take(&mut self.movers);
        movers.clear();
        for door in self.doors.iter().filter(|door| door.is_closed(time_s)) {
            let [from, to] = [door.from, door.to].map(|end| self.lattice_from_map * Point::from(end));
            movers.push(self.in_cells(Footprint::Segment { from, to }, 0.0, door.height_m, door.material));
        }
        for walker in &mut self.walkers {
            walker.walk_until(time_s, self.hull.as_ref().map(|hull| (map_from_base, hull)));
        }
        for walker in &self.walkers {
            for (center, radius_m) in walker.discs() {
                let footprint = Footprint::Disc { center: self.lattice_from_map * center, radius: radius_m };
                movers.push(self.in_cells(footprint, 0.0, walker.height_m(), Material::Opaque));
            }
        }
        if let Some(companion) = self.companion {
            let place = map_from_base * Point::new(companion.ahead_m, companion.left_m(time_s));
            let footprint =
                Footprint::Disc { center: self.lattice_from_map * place, radius: companion.radius_m };
            movers.push(self.in_cells(footprint, 0.0, COMPANION_HEIGHT_M, Material::Opaque));
        }
        self.movers = movers;
    }

    /// People and doors that a view shows, in cells.
    pub fn movers(&self, view: View) -> impl Iterator<Item = &Solid> {
        self.movers.iter().filter(move |solid| self.shows(view, solid))
    }

    fn shows(&self, view: View, solid: &Solid) -> bool {
        let (z_min_m, z_max_m) = (solid.z_min * self.resolution_m, solid.z_max * self.resolution_m);
        z_min_m <= view.z_max_m && z_max_m >= view.z_min_m && (view.with_glass || !solid.is_glass)
    }

    /// Whether nothing moves here.
    pub fn is_still(&self) -> bool {
        self.walkers.is_empty() && self.doors.is_empty() && self.companion.is_none()
    }

    /// Number of the lattice for a view, made at the first call.
    pub fn prepare(&mut self, view: View) -> usize {
        if let Some((_, number)) = self.views.iter().find(|(known, _)| *known == view) {
            return *number;
        }
        let shown = self.solids.iter().enumerate().filter(|(_, solid)| self.shows(view, solid));
        let members = Members {
            walls: !self.walls.is_empty() && self.wall_height_m >= view.z_min_m,
            solids: shown.map(|(idx, _)| idx as u32).collect(),
        };
        let number = self.lattices.iter().position(|(known, _)| *known == members).unwrap_or_else(|| {
            let solids = members.solids.iter().map(|&idx| self.solids[idx as usize]).collect();
            let is_wall = |col, row| members.walls && self.walls[row * self.size.0 + col];
            let lattice = Lattice::new(self.size, self.wall_height_m / self.resolution_m, solids, is_wall);
            self.lattices.push((members, lattice));
            self.lattices.len() - 1
        });
        self.views.push((view, number));
        number
    }

    /// A lattice that [`prepare`](Self::prepare) made.
    pub fn lattice(&self, number: usize) -> &Lattice {
        &self.lattices[number].1
    }
}

/// Heights and material of a footprint: from, to, of what.
type Upright = (f64, f64, Material);

/// Walls and boxes of a scene in another frame, in meters.
fn footprints(scene: &WorldScene, frame_from_map: &Pose2) -> Vec<(Footprint, Upright)> {
    let walls = scene.walls.iter().map(|wall| {
        let [from, to] = [wall.from, wall.to].map(|end| frame_from_map * Point::from(end));
        (Footprint::Segment { from, to }, (wall.z_min_m, wall.z_max_m, wall.material))
    });
    let boxes = scene.boxes.iter().map(|solid| {
        let center = frame_from_map * Point::from(solid.center);
        let yaw_rad = solid.yaw_rad + frame_from_map.rotation.angle();
        let footprint = Footprint::rectangle(center, Vector::from(solid.size), yaw_rad);
        (footprint, (solid.z_min_m, solid.z_max_m, solid.material))
    });
    walls.chain(boxes).collect()
}
