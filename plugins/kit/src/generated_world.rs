//! Deterministic worlds for benches and tests: rooms by recursive division, and open ground with boxes.
//!
//! Everything follows from a splitmix64 seed (Steele, Lea, Flood, "Fast splittable pseudorandom number generators",
//! 2014), so other programs can build the same worlds to the byte and be timed on the same work.

use crate::GridSize;

/// Cell cost from which a cell is closed to planners: the robot's hull touches an obstacle.
pub const INSCRIBED: u8 = 253;
/// Cell cost of an obstacle.
pub const LETHAL: u8 = 254;

/// The stream of random numbers.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// An integer of `low..=high`.
    fn within(&mut self, low: i64, high: i64) -> i64 {
        low + (self.next() % (high - low + 1) as u64) as i64
    }
}

/// A square map: 0 free, 1 occupied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GeneratedWorld {
    /// Size of the map.
    pub size: GridSize,
    /// One byte a cell.
    pub occupied: Vec<u8>,
}

/// A rectangle of cells, both corners included.
#[derive(Clone, Copy)]
struct Area {
    x0: i64,
    y0: i64,
    x1: i64,
    y1: i64,
}

impl Area {
    fn new(x0: i64, y0: i64, x1: i64, y1: i64) -> Self {
        Self { x0, y0, x1, y1 }
    }
}

const SMALLEST_ROOM: i64 = 80;
const DOOR_LENGTH: i64 = 28;
const ONE_MORE_DOOR_EACH: i64 = 400;

impl GeneratedWorld {
    /// An office-like square of `n` x `n` cells: walls three cells thick, doors, boxes in the rooms.
    pub fn indoor(n: usize, seed: u64) -> Self {
        let mut world = Self::walled(n);
        let n = n as i64;
        world.divide(&mut SplitMix64(seed), Area::new(3, 3, n - 4, n - 4));
        world
    }

    /// Open ground of `n` x `n` cells with one small box for every 20,000 cells.
    pub fn open_ground(n: usize, seed: u64) -> Self {
        let mut world = Self::walled(n);
        let mut rng = SplitMix64(seed);
        let last = n as i64 - 40;
        for _ in 0..n * n / 20_000 {
            let (x, y) = (rng.within(10, last), rng.within(10, last));
            // The second corner is drawn y first.
            let y1 = y + rng.within(3, 24);
            let x1 = x + rng.within(3, 24);
            world.fill(Area::new(x, y, x1, y1), 1);
        }
        world
    }

    fn walled(n: usize) -> Self {
        let size = GridSize::new(n, n);
        let mut world = Self { size, occupied: vec![0; size.n_cells()] };
        let last = n as i64 - 1;
        world.fill(Area::new(0, 0, last, 2), 1);
        world.fill(Area::new(0, last - 2, last, last), 1);
        world.fill(Area::new(0, 0, 2, last), 1);
        world.fill(Area::new(last - 2, 0, last, last), 1);
        world
    }

    fn fill(&mut self, area: Area, value: u8) {
        let (last_x, last_y) = (self.size.width as i64 - 1, self.size.height as i64 - 1);
        let columns = area.x0.max(0) as usize..=area.x1.min(last_x) as usize;
        for y in area.y0.max(0)..=area.y1.min(last_y) {
            self.occupied[y as usize * self.size.width..][columns.clone()].fill(value);
        }
    }

    fn divide(&mut self, rng: &mut SplitMix64, area: Area) {
        let Area { x0, y0, x1, y1 } = area;
        let (width, height) = (x1 - x0, y1 - y0);
        if width < 2 * SMALLEST_ROOM && height < 2 * SMALLEST_ROOM {
            self.furnish(rng, area);
        } else if width >= height {
            let x = rng.within(x0 + SMALLEST_ROOM, x1 - SMALLEST_ROOM);
            self.fill(Area::new(x - 1, y0, x + 1, y1), 1);
            for _ in 0..1 + height / ONE_MORE_DOOR_EACH {
                let door = rng.within(y0 + 6, y1 - 34);
                self.fill(Area::new(x - 1, door, x + 1, door + DOOR_LENGTH), 0);
            }
            self.divide(rng, Area::new(x0, y0, x - 2, y1));
            self.divide(rng, Area::new(x + 2, y0, x1, y1));
        } else {
            let y = rng.within(y0 + SMALLEST_ROOM, y1 - SMALLEST_ROOM);
            self.fill(Area::new(x0, y - 1, x1, y + 1), 1);
            for _ in 0..1 + width / ONE_MORE_DOOR_EACH {
                let door = rng.within(x0 + 6, x1 - 34);
                self.fill(Area::new(door, y - 1, door + DOOR_LENGTH, y + 1), 0);
            }
            self.divide(rng, Area::new(x0, y0, x1, y - 2));
            self.divide(rng, Area::new(x0, y + 2, x1, y1));
        }
    }

    fn furnish(&mut self, rng: &mut SplitMix64, room: Area) {
        for _ in 0..rng.within(0, 3) {
            let (width, height) = (rng.within(4, 16), rng.within(4, 16));
            if room.x1 - room.x0 - width < 30 || room.y1 - room.y0 - height < 30 {
                continue;
            }
            let x = rng.within(room.x0 + 12, room.x1 - width - 12);
            let y = rng.within(room.y0 + 12, room.y1 - height - 12);
            self.fill(Area::new(x, y, x + width, y + height), 1);
        }
    }

    /// Cell costs as ROS inflates them at 5 cm a cell: 254 occupied, 253 within 0.20 m, fading to 0 at 0.55 m.
    /// `squared_distance` is the squared distance to the nearest occupied cell, in cells.
    pub fn inflated(&self, squared_distance: &[u32]) -> Vec<u8> {
        const RESOLUTION_M: f32 = 0.05;
        let cost = |(&occupied, &squared): (&u8, &u32)| {
            // Single precision throughout: the bytes must equal those of other programs.
            let distance_m = (squared as f32).sqrt() * RESOLUTION_M;
            if occupied == 1 {
                LETHAL
            } else if distance_m <= 0.20 {
                INSCRIBED
            } else if distance_m > 0.55 {
                0
            } else {
                (252.0 * (-10.0 * (distance_m - 0.20)).exp()) as u8
            }
        };
        self.occupied.iter().zip(squared_distance).map(cost).collect()
    }
}

/// Entry cost of each cell in straight steps, from cell costs by the ROS convention: `(50 + 0.8 cost) / 50`.
pub fn entry_costs(cell_costs: &[u8]) -> Vec<f64> {
    let entry = |&cost: &u8| {
        if cost >= INSCRIBED { f64::INFINITY } else { (50.0 + (0.8 * f64::from(cost)).floor()) / 50.0 }
    };
    cell_costs.iter().map(entry).collect()
}

/// The start and goal cell every planner is timed between: from (1/8, 1/8) and (13/16, 13/16) of the map, the first
/// cell to the right with a cost below 100.
pub fn query_cells(size: GridSize, cell_costs: &[u8]) -> (usize, usize) {
    let pick = |col: usize, row: usize| {
        let from = size.index(col, row);
        from + cell_costs[from..].iter().position(|&cost| cost < 100).unwrap_or(0)
    };
    (pick(size.width / 8, size.height / 8), pick(size.width * 13 / 16, size.height * 13 / 16))
}

/// CRC-32 (ISO 3309) of bytes: lets a test pin a whole map by one number.
pub fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    };
    !bytes.iter().fold(!0, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance_field::squared_distance_field;

    /// Checksums of the maps that an independent C++ program wrote from the same description.
    #[test]
    fn worlds_equal_those_of_the_independent_generator() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        let indoor = GeneratedWorld::indoor(1000, 4242);
        assert_eq!(crc32(&indoor.occupied), INDOOR_1000);
        let indoor = GeneratedWorld::indoor(2000, 2042);
        assert_eq!(crc32(&indoor.occupied), INDOOR_2000);
        let open = GeneratedWorld::open_ground(2000, 2007);
        assert_eq!(crc32(&open.occupied), OPEN_2000);
        let costs = indoor.inflated(&squared_distance_field(indoor.size, &indoor.occupied));
        assert_eq!(crc32(&costs), INDOOR_2000_COST);
    }

    const INDOOR_1000: u32 = 0xE5C5_F527;
    const INDOOR_2000: u32 = 0x59C4_BEB4;
    const OPEN_2000: u32 = 0xDB13_4B26;
    const INDOOR_2000_COST: u32 = 0x57BC_E0F7;
}
