//! A map builder of a library.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{EstimateLoan, SeenLoan};
use super::call::{Instance, Pushed, lend_cx, push_bytes};
use super::map_mut::MapHandle;
use crate::map::Map;
use crate::stages::{Cx, MapBuilder, MapError, MapInput};

/// A map builder of a library.
pub(super) struct DynMapBuilder {
    instance: Instance,
    table: rumbo_map_builder_table,
    seen: SeenLoan,
    estimate: EstimateLoan,
}

impl DynMapBuilder {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_map_builder_table) -> DynMapBuilder {
        DynMapBuilder { instance, table, seen: SeenLoan::default(), estimate: EstimateLoan::default() }
    }
}

impl MapBuilder for DynMapBuilder {
    fn start(&mut self, map: &mut Map) -> Result<(), MapError> {
        let Some(start) = self.table.start else {
            return Err(MapError::Other("the plugin has no function `start`".to_owned()));
        };
        let mut map = MapHandle::new(map);
        // SAFETY: a function of the instance's own table; the map is borrowed until it returns.
        self.instance.call::<MapError>(|this, error| unsafe { start(this, map.lend(), error) })?;
        map.end().map_err(|bad| MapError::Other(self.instance.nonsense(bad)))
    }

    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError> {
        let Some(insert) = self.table.insert else {
            return Err(MapError::Other("the plugin has no function `insert`".to_owned()));
        };
        let call = lend_cx(cx);
        let seen = self.seen.lend(input.seen.iter());
        let estimate = self.estimate.lend(input.estimate);
        let mut map = MapHandle::new(map);
        self.instance.call::<MapError>(|this, error| {
            let (call, seen, estimate) = (&raw const call, &raw const seen, &raw const estimate);
            // SAFETY: a function of the instance's own table; everything is borrowed until it returns.
            unsafe { insert(this, call, seen, estimate, map.lend(), error) }
        })?;
        map.end().map_err(|bad| MapError::Other(self.instance.nonsense(bad)))
    }

    fn save(&self, map: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        let Some(save) = self.table.save else { return Ok(None) };
        let mut bytes = Pushed::<u8>::new();
        let size = size_of::<rumbo_bytes_out>();
        let mut out = rumbo_bytes_out { size, ctx: bytes.begin(), push: Some(push_bytes) };
        let mut map = MapHandle::new(map);
        self.instance.look::<MapError>(|this, error| {
            // SAFETY: a function of the instance's own table; map and output live until it returns.
            unsafe { save(this, map.lend(), &raw mut out, error) }
        })?;
        map.end().map_err(|bad| MapError::Other(self.instance.nonsense(bad)))?;
        if let Some(fault) = bytes.fault("what it keeps beside a map") {
            return Err(MapError::Other(self.instance.nonsense(fault)));
        }
        Ok((!bytes.items.is_empty()).then_some(bytes.items))
    }
}
