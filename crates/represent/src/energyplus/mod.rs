//! Windows for EnergyPlus: the objects of a `Construction:ComplexFenestrationState` and all that it names.
//!
//! Facts of EnergyPlus 25.2: a matrix has scattered directions as rows and incident ones as columns, both by their direction
//! of travel, 1/sr; front is outside; the field named "Visible … Back Transmittance" is the back *reflectance*; front
//! reflectance is no input, but 1 less transmittance and absorptances; borders of rings are rebuilt from their centres.

mod layer;
mod objects;
mod system;

pub use layer::Layer;
pub use objects::{Form, Object};

use std::path::Path;

use bsdfkit::matrix::KlemsBasis;
use bsdfkit::{Error, Result, replace_file};

use system::System;

/// What `window` needs to know beside the layers.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Name of the construction, before that of every other object.
    pub name: String,
    /// Width of the air between two layers, m.
    pub gap: f64,
}

/// A window's objects, and what is said of them.
#[derive(Clone, Debug)]
pub struct Window {
    objects: Vec<Object>,
    /// Share of transmitted light that the program sends elsewhere when it comes from sky and ground, as it takes the
    /// transposed matrix for these: ‖T − Tᵀ‖ / 2 ‖T‖, by projected solid angle.
    pub transposed: f64,
    /// Solar transmittance, by direction of travel, of every incident patch.
    pub transmittance: Vec<f64>,
    /// Solar absorptances of each layer for light from outside, alike.
    pub absorptances: Vec<Vec<f64>>,
}

impl Window {
    /// One or two layers, the outermost first, of the same basis.
    ///
    /// Two layers are put together by the matrix method with all reflections between them. [K94]
    ///
    /// Errors: argument, for another number of layers and for a name that an IDF cannot hold.
    pub fn new(layers: &[Layer], settings: &Settings) -> Result<Self> {
        let [first, ..] = layers else { return Err(wrong_number(0)) };
        let name = settings.name.trim();
        if name.is_empty() || name.contains([',', ';', '!', '\n']) {
            let text =
                format!("name: expected a text without comma, semicolon and !, found {name:?}");
            return Err(Error::argument(text));
        }
        if !(settings.gap.is_finite() && settings.gap > 0.0) {
            let text = format!("gap: expected metres above 0, found {}", settings.gap);
            return Err(Error::argument(text));
        }
        let basis = first.basis().clone();
        if layers.iter().any(|l| *l.basis() != basis) {
            return Err(Error::argument("layers: expected the same basis of all"));
        }
        let (solar, visible) = match layers {
            [one] => (System::of(&one.solar, &basis), System::of(&one.visible, &basis)),
            [outer, inner] => (
                System::of_two(&outer.solar, &inner.solar, &basis)?,
                System::of_two(&outer.visible, &inner.visible, &basis)?,
            ),
            more => return Err(wrong_number(more.len())),
        };
        let transposed = transposed(&solar.transmission, &basis);
        let objects = objects::all(name, layers, &solar, &visible, settings.gap, &basis);
        Ok(Self {
            objects,
            transposed,
            transmittance: solar.transmittance(&basis),
            absorptances: solar.absorbed_front,
        })
    }

    /// The objects, in the order of the file.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// Writes the objects to a file, which is replaced whole or not at all.
    ///
    /// Errors: io.
    pub fn write(&self, path: &Path, form: Form) -> Result<()> {
        replace_file(path, |out| objects::write(out, &self.objects, form))
    }
}

fn wrong_number(found: usize) -> Error {
    Error::argument(format!(
        "layers: expected one or two, the outermost first, found {found}: WINDOW makes one BSDF of more"
    ))
}

/// Half of Σ |T − Tᵀ| over Σ T, by projected solid angle of both patches.
fn transposed(values: &[f64], basis: &KlemsBasis) -> f64 {
    let n = basis.directions();
    let omega: Vec<f64> = (0..n).map(|k| basis.projected_solid_angle(k)).collect();
    let (mut differs, mut total) = (0.0, 0.0);
    for o in 0..n {
        for i in 0..n {
            let weight = omega[o] * omega[i];
            total += values[o * n + i] * weight;
            differs += 0.5 * (values[o * n + i] - values[i * n + o]).abs() * weight;
        }
    }
    if total > 0.0 { differs / total } else { 0.0 }
}
