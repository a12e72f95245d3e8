//! One kind of light within a frame: its passes, its reservoirs, and the order of both.

use super::constants;
use crate::Result;
use crate::gpu::{Buffer, ComputePass, Device, Recording, Usage};
use crate::layouts::{
    INDIRECT_COMPACT_WORDS, MIS_BALANCE, MIS_CONSTANT, MIS_DEFENSIVE, MIS_PAIRWISE, PILOT_WORDS,
    RestirConstants, SpatialStep, VISIBILITY_FINAL, VISIBILITY_INITIAL, VISIBILITY_NONE,
    VISIBILITY_WEIGHTS,
};
use crate::render::kind::Kind;
use crate::render::offered::Offered;
use crate::render::reservoirs::ReservoirLayout;
use crate::render::settings::{Mis, Resampling, Reuse, Settings, Shift, Visibility};
use std::sync::Arc;

crate::bindings! {
    /// What the pass `initial_direct` is bound to.
    pub struct InitialDirect {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read pilots,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// What the pass `initial_indirect` is bound to; it finds its pilots where it puts its reservoirs.
    pub struct InitialIndirect {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// What the passes `temporal_…` are bound to.
    pub struct Temporal {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read previous_sample_data,
        read history,
        write reservoirs,
        write counters,
    }
}

crate::bindings! {
    /// What the passes `spatial_…` are bound to.
    pub struct Spatial {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read neighbours,
        write reservoirs,
        write color,
        write counters,
    }
}

crate::bindings! {
    /// What the passes `shade_…` are bound to.
    pub struct Shade {
        [offers scene: Offered]
        uniform restir,
        read sample_data,
        read reservoirs,
        write color,
        write counters,
    }
}

// Pilots lie in reservoirs of indirect light before those are written.
const _: () = assert!(PILOT_WORDS <= INDIRECT_COMPACT_WORDS);

/// Specialisation constants of all passes of a kind.
const MIS: u32 = 11;
const VISIBILITY: u32 = 12;
const NEIGHBOURS: u32 = 13;
/// Specialisation constants of `initial_indirect`.
const SHARES: u32 = 14;
const BIASED_SHIFT: u32 = 15;

/// What the kinds of a frame have in common.
pub struct Common<'a> {
    /// What every pass is offered.
    pub scene: &'a Offered,
    /// Primary surfaces.
    pub sample_data: &'a Buffer,
    /// Those of the last frame, if there was one and reuse over time.
    pub previous_sample_data: Option<&'a Buffer>,
    /// What the first BSDF rays met.
    pub pilots: &'a Buffer,
    /// The picture.
    pub color: &'a Buffer,
    /// What passes count.
    pub counters: &'a Buffer,
    /// Workgroups of a pass over all pixels.
    pub groups: [u32; 3],
}

/// One kind of light: its passes, those of them that the settings need, since a driver takes seconds to
/// compile one, and its reservoirs.
pub struct Resampled {
    /// Which kind.
    pub kind: Kind,
    /// Whether its samples go to reservoirs; else the buffer of those holds pilots alone.
    pub shares: bool,
    /// How it is resampled.
    pub settings: Resampling,
    initial: ComputePass,
    temporal: Option<ComputePass>,
    spatial: Option<ComputePass>,
    /// Where no merge does it.
    shade: Option<ComputePass>,
    /// What its shaders were told.
    pub constants: RestirConstants,
    /// The buffer that told them.
    pub restir: Buffer,
    /// Each pass reads one and writes the other; the first is the one to be written next.
    pub reservoirs: Vec<Buffer>,
}

impl Resampled {
    /// How a kind is resampled with these settings and that many scattering events, if it is looked for
    /// at all.
    pub fn wanted(kind: Kind, settings: &Settings, bounces: u32) -> Option<Resampling> {
        (kind.is_looked_for(settings, bounces)).then(|| match kind {
            Kind::Direct => settings.direct.resampling(),
            Kind::Indirect => settings.indirect.resampling(),
        })
    }

    /// Bytes of each place in its reservoir buffers. Indirect light that is shared with nobody has only
    /// pilots there.
    pub fn reservoir_bytes(kind: Kind, settings: &Settings, layout: &ReservoirLayout) -> u64 {
        if kind.is_shared(settings) {
            layout.bytes(kind)
        } else {
            u64::from(4 * PILOT_WORDS)
        }
    }

    /// Makes the passes and buffers of a kind; `pass` makes a pass by name with specialisation constants.
    ///
    /// # Errors
    /// More memory than the device has, or a shader that it refuses.
    pub fn new(
        device: &Arc<Device>,
        kind: Kind,
        resampling: Resampling,
        settings: &Settings,
        layout: &ReservoirLayout,
        slots: u32,
        pass: impl Fn(&str, &[(u32, u32)]) -> Result<ComputePass>,
    ) -> Result<Self> {
        let shares = kind.is_shared(settings);
        let mut special = specialisation(&resampling).to_vec();
        special.push((SHARES, shares.into()));
        let biased = settings.indirect.shift == Shift::Biased;
        special.push((BIASED_SHIFT, biased.into()));
        let names = kind.passes();
        // The last merge knows the light of all that it merged, unless that has to be looked for yet.
        let needs_no_ray = matches!(
            resampling.visibility,
            Visibility::None | Visibility::Weights
        );
        let merge_shades = resampling.reuse.is_spatial() && needs_no_ray;
        let if_needed = |needed: bool, name: &str| needed.then(|| pass(name, &special)).transpose();
        let uniform = Usage {
            uniform: true,
            ..Usage::default()
        };
        let bytes = size_of::<RestirConstants>() as u64;
        let reservoirs = if resampling.reuse == Reuse::None {
            1
        } else {
            2
        };
        let reservoir_bytes = u64::from(slots) * Self::reservoir_bytes(kind, settings, layout);
        Ok(Self {
            kind,
            shares,
            settings: resampling,
            initial: pass(names.initial, &special)?,
            temporal: if_needed(resampling.reuse.is_temporal(), names.temporal)?,
            spatial: if_needed(resampling.reuse.is_spatial(), names.spatial)?,
            shade: if_needed(shares && !merge_shades, names.shade)?,
            constants: RestirConstants::default(),
            restir: Buffer::new(device, "restir", bytes, uniform)?,
            reservoirs: (0..reservoirs)
                .map(|_| Buffer::new(device, "reservoirs", reservoir_bytes, Usage::default()))
                .collect::<Result<_>>()?,
        })
    }

    /// Tells the shaders of the next frame.
    ///
    /// # Errors
    /// The device fails.
    pub fn tell(&mut self, frame: &RestirConstants) -> Result<()> {
        self.constants = constants::of_kind(frame, &self.settings);
        self.restir.write(&[self.constants])
    }

    /// Records a frame's passes. Returns which of the reservoir buffers holds the frame's last.
    ///
    /// # Errors
    /// A binding that a pass does not have.
    pub fn record<'a>(
        &'a self,
        recording: &mut Recording<'a>,
        common: &Common<'a>,
    ) -> Result<usize> {
        let Common {
            scene,
            sample_data,
            previous_sample_data,
            pilots,
            color,
            counters,
            groups,
        } = *common;
        let restir = &self.restir;
        let mut current = 0;

        let reservoirs = &self.reservoirs[current];
        match self.kind {
            Kind::Direct => {
                let initial = InitialDirect {
                    scene,
                    restir,
                    sample_data,
                    pilots,
                    reservoirs,
                    color,
                    counters,
                };
                recording.pass(&self.initial, &initial, &(), groups)?;
            }
            Kind::Indirect => {
                let initial = InitialIndirect {
                    scene,
                    restir,
                    sample_data,
                    reservoirs,
                    color,
                    counters,
                };
                recording.pass(&self.initial, &initial, &(), groups)?;
            }
        }

        if let (Some(pass), Some(previous_sample_data)) = (&self.temporal, previous_sample_data) {
            let temporal = Temporal {
                scene,
                restir,
                sample_data,
                previous_sample_data,
                history: &self.reservoirs[1],
                reservoirs: &self.reservoirs[current],
                counters,
            };
            recording.pass(pass, &temporal, &(), groups)?;
        }

        if let Some(pass) = &self.spatial {
            for number in 0..self.constants.spatial_passes {
                let spatial = Spatial {
                    scene,
                    restir,
                    sample_data,
                    neighbours: &self.reservoirs[current],
                    reservoirs: &self.reservoirs[1 - current],
                    color,
                    counters,
                };
                let last = number + 1 == self.constants.spatial_passes;
                let step = SpatialStep {
                    number,
                    shades: (last && self.shade.is_none()).into(),
                };
                recording.pass(pass, &spatial, &step, groups)?;
                current = 1 - current;
            }
        }

        if let Some(pass) = &self.shade {
            let shade = Shade {
                scene,
                restir,
                sample_data,
                reservoirs: &self.reservoirs[current],
                color,
                counters,
            };
            recording.pass(pass, &shade, &(), groups)?;
        }
        Ok(current)
    }
}

/// The specialisation constants that tell a kind's passes how to merge.
pub fn specialisation(resampling: &Resampling) -> [(u32, u32); 3] {
    let mis = match resampling.mis {
        Mis::Constant => MIS_CONSTANT,
        Mis::Balance => MIS_BALANCE,
        Mis::Pairwise => MIS_PAIRWISE,
        Mis::Defensive => MIS_DEFENSIVE,
    };
    let visibility = match resampling.visibility {
        Visibility::None => VISIBILITY_NONE,
        Visibility::Final => VISIBILITY_FINAL,
        Visibility::Initial => VISIBILITY_INITIAL,
        Visibility::Weights => VISIBILITY_WEIGHTS,
    };
    [
        (MIS, mis),
        (VISIBILITY, visibility),
        (NEIGHBOURS, resampling.spatial.neighbours),
    ]
}
