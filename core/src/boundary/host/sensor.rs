//! A sensor of a library.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::SeenLoan;
use super::call::{Instance, lend_cx};
use super::world::{AnswerViews, OutHandle, WorldHandle};
use crate::messages::{Observations, Seen, SensorId};
use crate::stages::{Cx, Sensor, SensorError, World};

/// A sensor of a library.
pub(super) struct DynSensor {
    instance: Instance,
    table: rumbo_sensor_table,
    sensor: SensorId,
    seen: SeenLoan,
    answers: AnswerViews,
}

impl DynSensor {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_sensor_table, sensor: SensorId) -> DynSensor {
        DynSensor { instance, table, sensor, seen: SeenLoan::default(), answers: AnswerViews::default() }
    }
}

impl Sensor for DynSensor {
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let Some(poll) = self.table.poll else {
            return Err(SensorError::Other("the plugin has no function `poll`".to_owned()));
        };
        let call = lend_cx(cx);
        let mut world = WorldHandle::new(world, &mut self.answers);
        let mut out = OutHandle::new(out, self.sensor);
        self.instance.call::<SensorError>(|this, error| {
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { poll(this, &raw const call, world.lend(), out.lend(), error) }
        })?;
        out.end().map_err(|bad| SensorError::Other(self.instance.nonsense(bad)))
    }

    fn derive(
        &mut self,
        cx: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let derive = self.table.derive.ok_or(SensorError::NotVirtual)?;
        let call = lend_cx(cx);
        let inputs = self.seen.lend(inputs.iter());
        let mut out = OutHandle::new(out, self.sensor);
        self.instance.call::<SensorError>(|this, error| {
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { derive(this, &raw const call, &raw const inputs, out.lend(), error) }
        })?;
        out.end().map_err(|bad| SensorError::Other(self.instance.nonsense(bad)))
    }
}
