//! `MultivariablePlant`: the glue from [`steerwright_models::SampledSystem`] to the export trait.
//!
//! The names and units of its inputs and outputs are those of the channels in its document. The table has a row for as
//! many as a document can have; an archive has those of its own.

use self::Variable as V;
use crate::fmu::{Definition, Role};
use crate::resources::{required, with_start_values};
use crate::saved::{check_settable, decode, encode, outputs_are_finite, refuse};
use crate::scenario::{Moment, Scenario, weave};
use fmi2_export::{
    Capabilities, CoSimulationUnit, Known, Log, Resources, StatedVariable, Unknown, VariableId,
};
use model_description::DependsOn::{Nothing, On};
use model_description::{
    BaseUnit, Causality, DependencyKind, Table, Unit, Value, Variability, VariableSpec,
};
use std::sync::Arc;
use steerwright_formats::PhysicalUnit;
use steerwright_models::{SampledSystem, SavedSampledSystem};

/// A variable of the multivariable plant. Between grid points an output is held; at them it depends on the inputs that the
/// document's D and delays let through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    /// The input of that number, from 0.
    Input(usize),
    /// The output of that number, from 0.
    Output(usize),
    /// Noise relative to the identified.
    NoiseScale,
    /// The name of the noise sequence.
    NoiseSeed,
}

/// Rows for the inputs, and as many for the outputs.
const CHANNELS: usize = steerwright_formats::multivariable::MOST;
/// Value references of the first output and of the noise.
const FIRST_OUTPUT: u32 = 100;
const NOISE: u32 = 200;

macro_rules! names {
    ($($number:literal)*) => {
        [$((concat!("input_", $number), concat!("output_", $number))),*]
    };
}

/// Names in the table, which those of the channels replace.
const NAMES: [(&str, &str); CHANNELS] = names![
    1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
    33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
];

static ROWS: [VariableSpec; 2 * CHANNELS + 2] = {
    let scale = VariableSpec::real("noise_scale", NOISE, Causality::Parameter, Variability::Fixed)
        .unit("1")
        .min(0.0)
        .description("noise relative to the identified: 0 deterministic, 1 as identified");
    let seed =
        VariableSpec::integer("noise_seed", NOISE + 1, Causality::Parameter, Variability::Fixed)
            .description("names the noise sequence");
    let mut rows = [scale; 2 * CHANNELS + 2];
    rows[2 * CHANNELS + 1] = seed;
    let mut i = 0;
    while i < CHANNELS {
        let (input, output) = NAMES[i];
        let reference = i as u32;
        rows[i] = VariableSpec::real(input, reference, Causality::Input, Variability::Continuous)
            .description("an input, by the name of its channel; it starts at its offset");
        rows[CHANNELS + i] = VariableSpec::real(
            output,
            FIRST_OUTPUT + reference,
            Causality::Output,
            Variability::Discrete,
        )
        .description("an output, by the name of its channel")
        .depends_on(Nothing)
        .initial_depends_on(On(&["noise_scale", "noise_seed"]));
        i += 1;
    }
    rows
};

impl VariableId for Variable {
    #[inline]
    fn from_reference(reference: u32) -> Option<Self> {
        let within = |number: u32| usize::try_from(number).ok().filter(|n| *n < CHANNELS);
        match reference {
            NOISE => Some(Self::NoiseScale),
            _ if reference == NOISE + 1 => Some(Self::NoiseSeed),
            FIRST_OUTPUT.. => within(reference - FIRST_OUTPUT).map(Self::Output),
            _ => within(reference).map(Self::Input),
        }
    }

    #[inline]
    fn spec(self) -> &'static VariableSpec {
        let row = match self {
            Self::Input(number) => number,
            Self::Output(number) => CHANNELS + number,
            Self::NoiseScale => 2 * CHANNELS,
            Self::NoiseSeed => 2 * CHANNELS + 1,
        };
        &MultivariablePlant::TABLE.variables[row]
    }
}

/// The identified plant of named channels (eq 3–5).
#[derive(Debug, Clone)]
pub struct MultivariablePlant {
    system: SampledSystem,
    started: bool,
}

impl MultivariablePlant {
    /// The system; until the start as a start from the present settings would leave it.
    fn system(&mut self) -> &mut SampledSystem {
        if !self.started {
            self.system.start();
        }
        &mut self.system
    }
}

impl Definition for MultivariablePlant {
    type File = steerwright_formats::MultivariablePlant;
    const RESOURCE: &'static str = "plant.json";
    const ROLE: Role = Role::Plant;

    fn step_s(file: &Self::File) -> Option<f64> {
        Some(file.discrete.sample_time_s)
    }

    /// Ten seconds, or a hundred samples of a slow plant.
    fn experiment_s(_file: &Self::File, step_s: f64) -> f64 {
        (100.0 * step_s).max(10.0)
    }

    /// Each input about its offset, by the deviation that it had in the drive, at an instant of its own.
    fn scenario(file: steerwright_formats::MultivariablePlant) -> Scenario {
        let inputs = file.inputs;
        Scenario::new(move |name, Moment { course: t, .. }| {
            let number = inputs.iter().position(|input| input.name == name)?;
            let input = inputs.get(number)?;
            let late = 0.25 * (number % 8) as f64;
            Some(input.offset + input.standard_deviation * weave((t - late).max(0.0)))
        })
    }
}

impl CoSimulationUnit for MultivariablePlant {
    type Variable = V;
    const TABLE: &'static Table = &Table::new(
        "MultivariablePlant",
        env!("CARGO_PKG_VERSION"),
        "plant identified from named channels of a log: their inputs in, their outputs out",
        &ROWS,
    );
    /// The outputs are held between grid points and jump at them, so no derivative is useful.
    const CAPABILITIES: Capabilities = Capabilities { serializes: true, ..Capabilities::NONE };

    fn open(resources: &Resources) -> Result<Self, String> {
        let plant = required::<steerwright_formats::MultivariablePlant>(resources, Self::RESOURCE)?;
        let system = SampledSystem::new(Arc::new(plant));
        with_start_values(Self { system, started: false }, resources)
    }

    #[inline]
    fn has(&self, variable: V) -> bool {
        let plant = self.system.plant();
        match variable {
            V::Input(number) => number < plant.inputs.len(),
            V::Output(number) => number < plant.outputs.len(),
            V::NoiseScale | V::NoiseSeed => true,
        }
    }

    fn stated(&self, variable: V) -> Option<StatedVariable> {
        let plant = self.system.plant();
        let (name, column, unit, deviation) = match variable {
            V::Input(number) => {
                let input = plant.inputs.get(number)?;
                (&input.name, &input.column, &input.unit, input.standard_deviation)
            }
            V::Output(number) => {
                let output = plant.outputs.get(number)?;
                (&output.name, &output.column, &output.unit, output.standard_deviation)
            }
            V::NoiseScale | V::NoiseSeed => return None,
        };
        Some(StatedVariable {
            name: name.clone(),
            unit: Some(unit_of(unit)),
            nominal: if deviation > 0.0 { Some(deviation) } else { None },
            description: format!("channel {column} of the log"),
        })
    }

    #[inline]
    fn get(&mut self, variable: V) -> Value {
        let system = self.system();
        Value::Real(match variable {
            V::Input(number) => system.inputs.get(number).copied().unwrap_or_default(),
            V::Output(number) => system.output(number).unwrap_or_default(),
            V::NoiseScale => system.noise_scale,
            V::NoiseSeed => return Value::Integer(system.noise_seed),
        })
    }

    #[inline]
    fn set(&mut self, variable: V, value: &Value) {
        match (variable, value) {
            (V::Input(number), Value::Real(value)) => {
                if let Some(input) = self.system.inputs.get_mut(number) {
                    *input = *value;
                }
            }
            (V::NoiseScale, Value::Real(value)) => self.system.noise_scale = *value,
            (V::NoiseSeed, Value::Integer(seed)) => self.system.noise_seed = *seed,
            _ => {}
        }
    }

    fn exit_initialization(&mut self, _start_time: f64, _log: &mut Log) -> Result<(), String> {
        self.started = true;
        self.system.start();
        outputs_are_finite(self)
    }

    fn step(&mut self, _time: f64, step: f64, _log: &mut Log) -> Result<(), String> {
        self.system.step(step).map_err(|e| refuse(&e))
    }

    fn dependency(&self, unknown: Unknown<V>, known: Known<V>) -> Option<DependencyKind> {
        let (Unknown::Variable(V::Output(i)), Known::Variable(V::Input(j))) = (unknown, known)
        else {
            return None;
        };
        let plant = self.system.plant();
        let late = plant.inputs.get(j)?.delay_s > 0.0;
        let through = *plant.discrete.d.0.get(i)?.get(j)?;
        if late || through == 0.0 { None } else { Some(DependencyKind::Dependent) }
    }

    fn save(&self) -> Vec<u8> {
        encode(&(self.started, self.system.save()))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let saved: SavedSampledSystem;
        let mut loaded = self.clone();
        (loaded.started, saved) = decode(bytes)?;
        loaded.system.restore(saved).map_err(|e| refuse(&e))?;
        check_settable(&mut loaded)?;
        *self = loaded;
        Ok(())
    }
}

/// The unit of a channel for the description; its name is that of the document.
fn unit_of(name: &str) -> Unit {
    // A document whose units are not known is refused when it is read.
    let known = PhysicalUnit::parse(name);
    let base = known.map(|unit| BaseUnit {
        exponents: unit.exponents,
        factor: unit.factor,
        offset: unit.offset,
    });
    Unit { name: name.into(), base, display_units: Vec::new() }
}
