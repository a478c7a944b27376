//! The whole state as bytes, to go on from later.

mod archive;
mod following;

use super::diary::{Diary, Entry};
use super::follower::Kept;
use super::lineage::{Branch, Lineage};
use super::particle::Particle;
use super::tracker::Tracker;
use crate::graph_slam::surface::SurfacePoint;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, is_finite2, pose2};
use rumbo_core::seal::{Broken, Reader, Seal};
use rumbo_core::stages::SlamError;
use rumbo_core::time::Time;
use rumbo_kit::streams::Streams;
use rumbo_kit::tile_map::TileCode;

const SEAL: Seal = Seal { magic: *b"RUMBORBP", version: 3 };

fn put(bytes: &mut Vec<u8>, numbers: &[f64]) {
    numbers.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
}

/// Real and imaginary part of the rotation, so that a pose comes back to the bit.
fn put_pose(bytes: &mut Vec<u8>, pose: &Pose2) {
    put(bytes, &[pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]);
}

fn put_pose_if(bytes: &mut Vec<u8>, pose: Option<Pose2>) {
    put_count(bytes, usize::from(pose.is_some()));
    put_pose(bytes, &pose.unwrap_or_else(Pose2::identity));
}

fn put_count(bytes: &mut Vec<u8>, n: usize) {
    bytes.extend((n as u32).to_le_bytes());
}

/// The state of a tracker that was started.
pub fn save(tracker: &Tracker) -> Vec<u8> {
    let mut bytes = SEAL.begin(1 << 20);
    bytes.extend(tracker.filter.streams.key().to_le_bytes());
    bytes.extend((tracker.filter.steps as i64).to_le_bytes());
    put_pose(&mut bytes, &tracker.map_from_start);
    put_count(&mut bytes, tracker.filter.particles.len());
    let mut code = TileCode::default();
    for particle in &tracker.filter.particles {
        put_pose(&mut bytes, &particle.map_from_base);
        put(&mut bytes, &[particle.ln_weight, particle.ln_total]);
        code.write(&particle.map, &mut bytes);
    }
    put_lineage(&mut bytes, &tracker.filter.lineage);
    put_diary(&mut bytes, &tracker.diary);
    following::put_tracker(&mut bytes, tracker);
    archive::put_archive(&mut bytes, &tracker.archive);
    put_recent(&mut bytes, tracker);
    Seal::close(bytes)
}

fn put_lineage(bytes: &mut Vec<u8>, lineage: &Lineage) {
    put_count(bytes, lineage.trunk.len());
    lineage.trunk.iter().for_each(|pose| put_pose(bytes, pose));
    put_count(bytes, lineage.layers.len());
    for layer in &lineage.layers {
        for branch in layer {
            put_count(bytes, branch.parent as usize);
            put_pose(bytes, &branch.map_from_base);
        }
    }
    lineage.tips.iter().for_each(|tip| put_count(bytes, *tip as usize));
}

fn put_diary(bytes: &mut Vec<u8>, diary: &Diary) {
    put_count(bytes, diary.entries.len());
    for entry in &diary.entries {
        bytes.extend(entry.stamp.0.to_le_bytes());
        put_count(bytes, entry.step as usize);
        put_pose(bytes, &entry.step_from_base);
    }
    put_count(bytes, diary.steps.len());
    for (stamp, pose) in &diary.steps {
        bytes.extend(stamp.0.to_le_bytes());
        put_pose(bytes, pose);
    }
}

fn put_recent(bytes: &mut Vec<u8>, tracker: &Tracker) {
    put_count(bytes, tracker.follower.recent.len());
    for kept in &tracker.follower.recent {
        put_pose(bytes, &kept.step_from_base);
        put_count(bytes, kept.surface.len());
        for point in &kept.surface {
            [point.at, point.normal].as_flattened().iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        }
    }
}

/// Reads bytes of one state.
struct State<'b>(Reader<'b>);

impl State<'_> {
    fn number(&mut self) -> Option<f64> {
        self.0.f64().filter(|v| v.is_finite())
    }

    fn numbers<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    fn count(&mut self) -> Option<usize> {
        self.0.u32().map(|n| n as usize)
    }

    fn time(&mut self) -> Option<Time> {
        self.0.i64().map(Time)
    }

    fn pose(&mut self) -> Option<Pose2> {
        let [x, y, re, im] = self.numbers()?;
        let is_rotation = (re * re + im * im - 1.0).abs() < 1e-6;
        let rotation = nalgebra::UnitComplex::new_unchecked(nalgebra::Complex::new(re, im));
        let pose = Pose2::from_parts(pose2(x, y, 0.0).translation, rotation);
        (is_rotation && is_finite2(&pose)).then_some(pose)
    }

    fn pose_if(&mut self) -> Option<Option<Pose2>> {
        let (is_there, pose) = (self.count()? > 0, self.pose()?);
        Some(is_there.then_some(pose))
    }

    fn many<T>(&mut self, mut one: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let n = self.count()?;
        // Not room for as many as are promised: bytes may lie.
        let mut all = Vec::new();
        for _ in 0..n {
            all.push(one(self)?);
        }
        Some(all)
    }

    fn lineage(&mut self, n_particles: usize) -> Option<Lineage> {
        let trunk = self.many(Self::pose)?;
        let layer = |state: &mut Self| {
            let branch = |_| Some(Branch { parent: state.count()? as u32, map_from_base: state.pose()? });
            (0..n_particles).map(branch).collect::<Option<Vec<Branch>>>()
        };
        let layers = self.many(layer)?.into();
        let tips = (0..n_particles).map(|_| Some(self.count()? as u32)).collect::<Option<Vec<u32>>>()?;
        Some(Lineage { trunk, layers, tips })
    }

    fn diary(&mut self) -> Option<Diary> {
        let entry = |state: &mut Self| {
            Some(Entry { stamp: state.time()?, step: state.count()? as u32, step_from_base: state.pose()? })
        };
        let entries = self.many(entry)?;
        let steps = self.many(|state| Some((state.time()?, state.pose()?)))?;
        Some(Diary { entries, steps })
    }

    fn single(&mut self) -> Option<f32> {
        self.0.chunk().map(f32::from_le_bytes).filter(|v| v.is_finite())
    }

    fn recent(&mut self, tracker: &mut Tracker) -> Option<()> {
        tracker.follower.recent.clear();
        for _ in 0..self.count()? {
            let (step_from_base, n) = (self.pose()?, self.count()?);
            let mut surface = Vec::new();
            for _ in 0..n {
                let at = [self.single()?, self.single()?];
                surface.push(SurfacePoint { at, normal: [self.single()?, self.single()?], variance_m2: 0.0 });
            }
            tracker.follower.recent.push_back(Kept { step_from_base, surface });
        }
        tracker.follower.fill();
        Some(())
    }

    fn whole(&mut self, tracker: &mut Tracker) -> Option<()> {
        tracker.filter.streams = Streams::of_key(u64::from_le_bytes(self.0.chunk()?));
        tracker.filter.steps = self.0.i64()? as u64;
        tracker.map_from_start = self.pose()?;
        let n = self.count().filter(|n| *n > 0)?;
        let mut code = TileCode::default();
        let mut particles = Vec::new();
        for _ in 0..n {
            let map_from_base = self.pose()?;
            let [ln_weight, ln_total] = self.numbers()?;
            particles.push(Particle { map_from_base, ln_weight, ln_total, map: code.read(&mut self.0)? });
        }
        tracker.filter.particles = particles;
        tracker.filter.lineage = self.lineage(n)?;
        tracker.diary = self.diary()?;
        self.tracker(tracker)?;
        tracker.archive = self.archive(tracker.filter.lineage.len())?;
        self.recent(tracker)?;
        self.0.is_empty().then_some(())
    }
}

/// Goes on from a saved state. After an error the tracker has not been started.
///
/// # Errors
/// What is wrong with the bytes, and maps of other cells than this pipeline asks for.
pub fn restore(tracker: &mut Tracker, bytes: &[u8]) -> Result<(), SlamError> {
    let damaged = || SlamError::Other("the saved state is damaged or cut off".into());
    let reader = SEAL.open(bytes).map_err(|broken| match broken {
        Broken::Foreign => SlamError::Other("the saved state is not one of rbpf_slam".into()),
        Broken::Version(found) => {
            let known = SEAL.version;
            SlamError::Other(format!(
                "the saved state has version {found}, this plugin reads version {known}"
            ))
        }
        Broken::Damaged => damaged(),
    })?;
    tracker.start(&Pose2::identity(), &Matrix3::zeros());
    tracker.is_started = false;
    State(reader).whole(tracker).ok_or_else(damaged)?;
    let settings = tracker.filter.settings();
    let (resolution_m, n_levels) = (settings.resolution_m, settings.n_levels as usize);
    let fits = tracker.filter.particles.iter().all(|particle| {
        let levels = particle.map.levels();
        levels.len() == n_levels && levels.first().is_some_and(|finest| finest.resolution_m() == resolution_m)
    });
    if !fits {
        let wanted = format!("{n_levels} levels and cells of {resolution_m} m");
        return Err(SlamError::Other(format!("the saved maps do not have the {wanted} of this pipeline")));
    }
    (tracker.is_started, tracker.may_be_another_clock) = (true, true);
    Ok(())
}
