//! A localizer of a library.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{EstimateLoan, MapLoan, SeenLoan, estimate_from, lend_prior};
use super::super::says_other::SaysOther;
use super::call::{Instance, Pushed, lend_cx};
use crate::map::Map;
use crate::messages::{Estimate, Prior, Seen};
use crate::stages::{Cx, LocalizeError, Localizer};
use crate::time::Time;

/// A localizer of a library.
pub(super) struct DynLocalizer {
    instance: Instance,
    table: rumbo_localizer_table,
    seen: SeenLoan,
    map: MapLoan,
    answer: AnswerSheet,
}

impl DynLocalizer {
    /// Of an instance with its functions.
    pub fn new(instance: Instance, table: rumbo_localizer_table) -> DynLocalizer {
        DynLocalizer {
            instance,
            table,
            seen: SeenLoan::default(),
            map: MapLoan::default(),
            answer: AnswerSheet::new(),
        }
    }
}

impl Localizer for DynLocalizer {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        let Some(start) = self.table.start else {
            return Err(LocalizeError::Other("the plugin has no function `start`".to_owned()));
        };
        let prior = lend_prior(prior);
        let map = self.map.lend(map);
        // SAFETY: a function of the instance's own table, with views that live until it returns.
        self.instance.call(|this, error| unsafe { start(this, &raw const prior, &raw const map, error) })
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        let Some(update) = self.table.update else {
            return Err(LocalizeError::Other("the plugin has no function `update`".to_owned()));
        };
        let call = lend_cx(cx);
        let seen = self.seen.lend(seen.iter());
        let map = self.map.lend(map);
        let (mut estimate, mut candidates) = self.answer.begin(cx.now);
        self.instance.call::<LocalizeError>(|this, error| {
            let (call, seen, map) = (&raw const call, &raw const seen, &raw const map);
            // SAFETY: a function of the instance's own table, with views that live until it returns.
            unsafe { update(this, call, seen, map, &raw mut estimate, &raw mut candidates, error) }
        })?;
        self.answer.end(estimate, &self.instance)
    }
}

/// What a plugin fills in: an estimate, and candidates apart.
pub(super) struct AnswerSheet {
    blank: EstimateLoan,
    candidates: Pushed<rumbo_candidate>,
}

impl AnswerSheet {
    /// Empty.
    pub fn new() -> AnswerSheet {
        AnswerSheet { blank: EstimateLoan::default(), candidates: Pushed::new() }
    }

    /// The estimate of a lost robot, and where candidates go.
    pub fn begin(&mut self, now: Time) -> (rumbo_estimate, rumbo_candidate_out) {
        let candidates = rumbo_candidate_out {
            size: size_of::<rumbo_candidate_out>(),
            ctx: self.candidates.begin(),
            push: Some(Pushed::<rumbo_candidate>::push),
        };
        (self.blank.lend(&Estimate::lost(now)), candidates)
    }

    /// What was filled in.
    pub fn end<E: SaysOther>(
        &self,
        mut estimate: rumbo_estimate,
        instance: &Instance,
    ) -> Result<Estimate, E> {
        if let Some(fault) = self.candidates.fault("a list of candidates") {
            return Err(E::other(instance.nonsense(fault)));
        }
        estimate.n_candidates = self.candidates.items.len();
        estimate.candidates = self.candidates.items.as_ptr();
        // SAFETY: the candidates are our own list.
        unsafe { estimate_from(&raw const estimate) }.map_err(|bad| E::other(instance.nonsense(bad)))
    }
}
