//! All effects of a row together, and viscosity alone: what the sweep calls, chunk by chunk.
//!
//! Method: an effect is a type with its constants and its state in one file: dependence on the rate
//! (`strain_rate.rs`), viscosity (`viscous.rs`), slack balance (`slack.rs`), case (`on_casing.rs`). They act
//! in that order.
//! Limits: those of each effect.
//! Reference: docs/model.md, "The step".

use crate::ground::lanes::Lane;
use crate::ground::planes::{Chunk, ENERGY_ERROR_PLANES, PAST_PLANES};
use crate::scene::features::Feature;
use crate::sheet::direction::PlyDirections;
use crate::sheet::neighbours::Around;
use crate::sweep::on_casing::{CasingChunk, OnCasing};
use crate::sweep::segments::{At, DamagedChunk, Dissipation, Effect, Fall, Segments, StateChunk, Yarns};
use crate::sweep::slack::{SlackBalance, SlackChunk};
use crate::sweep::strain_rate::StrainRate;
use crate::sweep::viscous::{Viscous, ViscousChunk, ViscousRow};
use crate::yarn::rate::Rates;
use core::hint::black_box;

/// State of the effects of a row.
pub struct EffectState<'a> {
    /// Past; None without viscosity.
    pub viscosity: Option<ViscousRow<'a>>,
    /// Balance of its slack segments; None where none has been slack.
    pub slack: Option<SlackBalance<'a>>,
    /// Case under it; None without.
    pub on_casing: Option<OnCasing<'a>>,
    /// Energy that viscosity and rate dissipate.
    pub dissipation: &'a mut Dissipation,
}

/// Effects of a row.
pub trait Effects<'a>: Sized {
    /// Effects of a chunk.
    type OnChunk<'c>: Effect
    where
        Self: 'c;

    /// Effects with this state, which they take, on segments in these directions. None without what they
    /// need.
    fn of(state: &mut Option<EffectState<'a>>, directions: PlyDirections<'a>, rates: &Rates) -> Option<Self>;

    /// Effects whose constants stay in memory over a loop: in registers they would take those of the
    /// segments.
    #[inline(always)]
    fn in_memory(&mut self) -> &mut Self {
        self
    }

    /// Effects on chunk c; None after the last.
    fn on_chunk(&mut self, c: usize) -> Option<Self::OnChunk<'_>>;
}

/// No effect.
impl Effects<'_> for () {
    type OnChunk<'c> = ();

    #[inline(always)]
    fn of(_: &mut Option<EffectState<'_>>, _: PlyDirections<'_>, _: &Rates) -> Option<()> {
        Some(())
    }

    #[inline(always)]
    fn on_chunk(&mut self, _: usize) -> Option<()> {
        Some(())
    }
}

/// Viscosity and no other effect.
pub struct ViscosityAlone<'a>(Viscous<'a>, &'a mut Dissipation);

impl<'a> Effects<'a> for ViscosityAlone<'a> {
    type OnChunk<'c>
        = ViscosityAloneOnChunk<'c>
    where
        Self: 'c;

    #[inline(always)]
    fn of(state: &mut Option<EffectState<'a>>, directions: PlyDirections<'a>, _: &Rates) -> Option<Self> {
        let EffectState { viscosity, dissipation, .. } = state.take()?;
        Some(ViscosityAlone(Viscous::of(directions, viscosity?), dissipation))
    }

    #[inline(always)]
    fn on_chunk(&mut self, c: usize) -> Option<ViscosityAloneOnChunk<'_>> {
        Some(ViscosityAloneOnChunk(self.0.on_chunk(c)?, self.1))
    }
}

/// [`ViscosityAlone`] of a chunk.
pub struct ViscosityAloneOnChunk<'c>(ViscousChunk<'c, &'c mut Chunk<PAST_PLANES>>, &'c mut Dissipation);

impl Effect for ViscosityAloneOnChunk<'_> {
    #[inline(always)]
    fn act<L: Lane>(&mut self, segments: &mut Segments<L>, place: &At<'_, L>) {
        let dissipated = self.0.act(segments, place);
        self.1.add(dissipated, L::splat(1.0), place);
    }

    #[inline(always)]
    fn add_forces<L: Lane>(&self, forces: &mut [[L; 3]; 2], group: usize) {
        self.0.add_forces(forces, group);
    }
}

/// All effects that a row has.
pub struct All<'a> {
    rate: Option<StrainRate<'a>>,
    viscosity: Option<Viscous<'a>>,
    slack: Option<SlackBalance<'a>>,
    on_casing: Option<OnCasing<'a>>,
    dissipation: Option<&'a mut Dissipation>,
}

impl<'a> Effects<'a> for All<'a> {
    type OnChunk<'c>
        = AllOnChunk<'c, &'c mut Chunk<PAST_PLANES>, &'c mut Chunk<ENERGY_ERROR_PLANES>>
    where
        Self: 'c;

    #[inline(always)]
    fn of(state: &mut Option<EffectState<'a>>, directions: PlyDirections<'a>, rates: &Rates) -> Option<Self> {
        let mut all = All { rate: None, viscosity: None, slack: None, on_casing: None, dissipation: None };
        let Some(EffectState { viscosity, slack, on_casing, dissipation }) = state.take() else { return Some(all) };
        all.rate = StrainRate::of(directions, rates);
        all.viscosity = viscosity.map(|row| Viscous::of(directions, row));
        (all.slack, all.on_casing) = (slack, on_casing);
        all.dissipation = Some(dissipation);
        Some(all)
    }

    #[inline(always)]
    fn in_memory(&mut self) -> &mut Self {
        black_box(self)
    }

    #[inline(always)]
    fn on_chunk(&mut self, c: usize) -> Option<Self::OnChunk<'_>> {
        let All { rate, viscosity, slack, on_casing, dissipation } = self;
        Some(AllOnChunk {
            rate: rate.as_ref(),
            viscosity: viscosity.as_mut().and_then(|viscosity| viscosity.on_chunk(c)),
            slack: slack.as_mut().and_then(|slack| slack.on_chunk(c)),
            on_casing: on_casing.as_mut().and_then(|on_casing| on_casing.on_chunk(c)),
            dissipation: dissipation.as_deref_mut(),
        })
    }
}

/// [`All`] of a chunk. `V`, `E`: state of viscosity and energy errors.
pub struct AllOnChunk<'c, V, E> {
    /// Dependence on the rate of strain.
    pub rate: Option<&'c StrainRate<'c>>,
    /// Viscosity.
    pub viscosity: Option<ViscousChunk<'c, V>>,
    /// Balance of slack segments.
    pub slack: Option<SlackChunk<E>>,
    /// Case.
    pub on_casing: Option<CasingChunk<'c>>,
    /// Energy that viscosity and rate dissipate; None where it is not asked for.
    pub dissipation: Option<&'c mut Dissipation>,
}

impl<V, E: DamagedChunk<ENERGY_ERROR_PLANES>> AllOnChunk<'_, V, E> {
    #[cold]
    fn note_fall(&mut self, fall: &Fall<'_>, yarns: &Yarns<'_>) {
        if let (Some(rate), Some(dissipation)) = (self.rate, &mut self.dissipation) {
            rate.note_fall(fall, yarns, dissipation);
        }
        if let Some(slack) = &mut self.slack {
            slack.note_fall(fall, yarns);
        }
    }
}

impl<V: StateChunk<PAST_PLANES>, E: DamagedChunk<ENERGY_ERROR_PLANES>> Effect for AllOnChunk<'_, V, E> {
    #[inline(always)]
    fn act<L: Lane>(&mut self, segments: &mut Segments<L>, place: &At<'_, L>) {
        if let Some(rate) = self.rate {
            let relaxed = rate.act(segments);
            if let Some(dissipation) = &mut self.dissipation {
                dissipation.add(relaxed, rate.relaxing(), place);
            }
        }
        if let Some(viscosity) = &mut self.viscosity {
            let dissipated = viscosity.act(segments, place);
            if let Some(dissipation) = &mut self.dissipation {
                dissipation.add(dissipated, L::splat(1.0), place);
            }
        }
        if let Some(slack) = &mut self.slack {
            slack.act(segments, place);
        }
    }

    #[inline(always)]
    fn note_damage<L: Lane>(&mut self, lanes: [[L; 2]; 2], now: [&L::Group; 2], column: usize, yarns: &Yarns<'_>) {
        let is_noted = Feature::Rate.is_built() || Feature::Slack.is_built();
        if let Some(fall) = Fall::of::<L>(lanes, now, column).filter(|_| is_noted) {
            self.note_fall(&fall, yarns);
        }
    }

    #[inline(always)]
    fn add_forces<L: Lane>(&self, forces: &mut [[L; 3]; 2], group: usize) {
        if let Some(viscosity) = &self.viscosity {
            viscosity.add_forces(forces, group);
        }
    }

    #[inline(always)]
    fn constrain<L: Lane>(&mut self, change: [L; 3], around: &Around<'_>, group: usize) -> [L; 3] {
        match &mut self.on_casing {
            Some(on_casing) => on_casing.constrain(change, around, group),
            None => change,
        }
    }
}
