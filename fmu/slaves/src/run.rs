//! An FMU's slave run in this process, without its C symbols: the code that its library runs.

use crate::{
    BicyclePlant, Fmu, IdentifiedPlant, LateralPid, NonlinearVehicle, PoseEstimator, ReferencePath,
};
use fmi2_export::{Log, Resources, Slave, VariableId};
use model_description::Value;

/// A slave of any FMU, between [`Fmu::open`] and the last step.
///
/// The checks that the FMI layer makes of its callers are not made here.
pub struct Running(Box<dyn Run>);

/// [`Slave`] without its types.
trait Run {
    fn get(&mut self, reference: u32) -> Option<Value>;
    fn set(&mut self, reference: u32, value: &Value);
    fn exit_initialization(&mut self, start_time: f64) -> Result<(), String>;
    fn step(&mut self, time: f64, step: f64) -> Result<(), String>;
}

impl<S: Slave> Run for S {
    fn get(&mut self, reference: u32) -> Option<Value> {
        S::Variable::from_reference(reference).map(|variable| Slave::get(self, variable))
    }

    fn set(&mut self, reference: u32, value: &Value) {
        if let Some(variable) = S::Variable::from_reference(reference) {
            Slave::set(self, variable, value);
        }
    }

    fn exit_initialization(&mut self, start_time: f64) -> Result<(), String> {
        Slave::exit_initialization(self, start_time, &mut Log::default())
    }

    fn step(&mut self, time: f64, step: f64) -> Result<(), String> {
        Slave::step(self, time, step, &mut Log::default())
    }
}

impl Fmu {
    /// Opens the slave on its resources.
    ///
    /// # Errors
    /// A text for people, where the slave refuses them.
    pub fn open(self, resources: Vec<(String, Vec<u8>)>) -> Result<Running, String> {
        fn boxed<S: Slave>(resources: &Resources) -> Result<Running, String> {
            Ok(Running(Box::new(S::open(resources)?)))
        }
        let resources = &Resources::from(resources);
        match self {
            Self::IdentifiedPlant => boxed::<IdentifiedPlant>(resources),
            Self::BicyclePlant => boxed::<BicyclePlant>(resources),
            Self::NonlinearVehicle => boxed::<NonlinearVehicle>(resources),
            Self::LateralPid => boxed::<LateralPid>(resources),
            Self::PoseEstimator => boxed::<PoseEstimator>(resources),
            Self::ReferencePath => boxed::<ReferencePath>(resources),
        }
    }
}

impl Running {
    /// The value of the variable with that reference, if there is one.
    pub fn get(&mut self, reference: u32) -> Option<Value> {
        self.0.get(reference)
    }

    /// Sets the variable with that reference, if there is one.
    pub fn set(&mut self, reference: u32, value: &Value) {
        self.0.set(reference, value);
    }

    /// Leaves initialization at `start_time` (s).
    ///
    /// # Errors
    /// The slave's text for people.
    pub fn exit_initialization(&mut self, start_time: f64) -> Result<(), String> {
        self.0.exit_initialization(start_time)
    }

    /// Advances from `time` by `step` (s).
    ///
    /// # Errors
    /// The slave's text for people.
    pub fn step(&mut self, time: f64, step: f64) -> Result<(), String> {
        self.0.step(time, step)
    }
}
