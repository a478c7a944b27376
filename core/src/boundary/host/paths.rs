//! The view of what an instance is made from.

use super::super::abi::*;
use super::super::convert::{RobotLoan, layer_bits, rumbo_pose3_of, text_of};
use super::call::Kept;
use super::callbacks::lend_flag;
use crate::stages::{BuildContext, BuildError};
use std::path::Path;

/// The paths of a context as text.
pub(super) struct Paths<'c> {
    folder: &'c str,
    world_map: &'c str,
    world_recording: &'c str,
}

impl<'c> Paths<'c> {
    /// Refused where one is no UTF-8.
    pub fn of(context: &'c BuildContext) -> Result<Paths<'c>, BuildError> {
        let text = |path: &'c Path| {
            let wrong = || {
                BuildError::at(
                    "plugin",
                    format!("the path {} is no UTF-8, which a plugin of a library needs", path.display()),
                )
            };
            path.to_str().ok_or_else(wrong)
        };
        let optional = |path: Option<&'c Path>| path.map_or(Ok(""), text);
        Ok(Paths {
            folder: text(&context.folder)?,
            world_map: optional(context.world_map.as_deref())?,
            world_recording: optional(context.world_recording.as_deref())?,
        })
    }

    /// A view that holds as long as what it is made of.
    pub fn lend(&self, context: &BuildContext, robot: &mut RobotLoan, kept: &Kept) -> rumbo_context {
        rumbo_context {
            size: size_of::<rumbo_context>(),
            name: text_of(&context.name),
            sensor: context.sensor.0,
            dry_run: context.dry_run.into(),
            is_threaded: context.background.is_threaded().into(),
            wanted_layers: layer_bits(&context.wanted_layers),
            robot: robot.lend(&context.robot),
            base_from_sensor: rumbo_pose3_of(&context.base_from_sensor),
            rate_hz: context.rate_hz.unwrap_or(f64::NAN),
            seed: context.seed,
            rng: std::ptr::from_ref(kept.rng.as_ref()).cast_mut().cast(),
            folder: text_of(self.folder),
            world_map: text_of(self.world_map),
            world_recording: text_of(self.world_recording),
            latency_ns: context.background.latency().0,
            abort: lend_flag(&kept.abort),
        }
    }
}
