//! A plugin of a library that builds the map and finds the robot in it.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{SeenLoan, lend_prior, stamped_pose_from};
use super::call::{Instance, Pushed, lend_cx, push_bytes};
use super::localizer::AnswerSheet;
use super::map_mut::MapHandle;
use crate::map::Map;
use crate::messages::{Estimate, Prior, Seen, StampedPose};
use crate::stages::{Cx, Slam, SlamError};

/// A SLAM plugin of a library.
pub(super) struct DynSlam {
    instance: Instance,
    table: rumbo_slam_table,
    seen: SeenLoan,
    answer: AnswerSheet,
}

impl DynSlam {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_slam_table) -> DynSlam {
        DynSlam { instance, table, seen: SeenLoan::default(), answer: AnswerSheet::new() }
    }
}

impl Slam for DynSlam {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        let Some(start) = self.table.start else {
            return Err(SlamError::Other("the plugin has no function `start`".to_owned()));
        };
        let prior = lend_prior(prior);
        let mut map = MapHandle::new(map);
        self.instance.call::<SlamError>(|this, error| {
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { start(this, &raw const prior, map.lend(), error) }
        })?;
        map.end().map_err(|bad| SlamError::Other(self.instance.nonsense(bad)))
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        let Some(update) = self.table.update else {
            return Err(SlamError::Other("the plugin has no function `update`".to_owned()));
        };
        let call = lend_cx(cx);
        let seen = self.seen.lend(seen.iter());
        let mut map = MapHandle::new(map);
        let (mut estimate, mut candidates) = self.answer.begin(cx.now);
        self.instance.call::<SlamError>(|this, error| {
            let (call, seen) = (&raw const call, &raw const seen);
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { update(this, call, seen, map.lend(), &raw mut estimate, &raw mut candidates, error) }
        })?;
        map.end().map_err(|bad| SlamError::Other(self.instance.nonsense(bad)))?;
        self.answer.end(estimate, &self.instance)
    }

    fn relocate(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        let relocate = self.table.relocate.ok_or(SlamError::CannotRelocate)?;
        let prior = lend_prior(prior);
        let mut map = MapHandle::new(map);
        self.instance.call::<SlamError>(|this, error| {
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { relocate(this, &raw const prior, map.lend(), error) }
        })?;
        map.end().map_err(|bad| SlamError::Other(self.instance.nonsense(bad)))
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        let Some(trajectory) = self.table.trajectory else { return Ok(Vec::new()) };
        let mut poses = Pushed::<rumbo_stamped_pose>::new();
        let size = size_of::<rumbo_trajectory_out>();
        let mut out = rumbo_trajectory_out { size, ctx: poses.begin(), push: Some(Pushed::push) };
        // SAFETY: a function of the instance's own table, with an output that lives until it returns.
        self.instance.look::<SlamError>(|this, error| unsafe { trajectory(this, &raw mut out, error) })?;
        let fault = poses.fault("a trajectory");
        if let Some(fault) = fault {
            return Err(SlamError::Other(self.instance.nonsense(fault)));
        }
        let taken: Result<Vec<_>, _> = poses.items.iter().map(stamped_pose_from).collect();
        taken.map_err(|bad| SlamError::Other(self.instance.nonsense(bad)))
    }

    fn save_map(&self, map: &mut Map) -> Result<(), SlamError> {
        let Some(save_map) = self.table.save_map else { return Ok(()) };
        let mut map = MapHandle::new(map);
        self.instance.look::<SlamError>(|this, error| {
            // SAFETY: a function of the instance's own table; the map lives until it returns.
            unsafe { save_map(this, map.lend(), error) }
        })?;
        map.end().map_err(|bad| SlamError::Other(self.instance.nonsense(bad)))
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        let save = self.table.save.ok_or(SlamError::CannotSave)?;
        let mut bytes = Pushed::<u8>::new();
        let size = size_of::<rumbo_bytes_out>();
        let mut out = rumbo_bytes_out { size, ctx: bytes.begin(), push: Some(push_bytes) };
        // SAFETY: a function of the instance's own table, with an output that lives until it returns.
        self.instance.look::<SlamError>(|this, error| unsafe { save(this, &raw mut out, error) })?;
        if let Some(fault) = bytes.fault("a saved state") {
            return Err(SlamError::Other(self.instance.nonsense(fault)));
        }
        Ok(bytes.items)
    }
}
