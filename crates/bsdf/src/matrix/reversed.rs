//! The opposite direction of travel.

use super::matrix::KlemsMatrix;
use crate::klems::KlemsBasis;
use crate::{DVec3, Error, Result};

impl KlemsMatrix {
    /// f′(wi, wo) = f(wo, wi): what a lone transmission answers for light that travels the other
    /// way.
    ///
    /// In travel indexing f′ = P fᵀ P, where P turns a patch by 180° about the normal.
    /// Errors: argument for a ring of an odd number of patches, which turned are no patches.
    pub fn reversed(&self) -> Result<Self> {
        let turned_incident = turned(self.incident())?;
        let turned_scattered = turned(self.scattered())?;
        let columns = self.scattered().directions();
        let entries = || {
            let row = |o: usize| turned_incident.iter().map(move |&i| i * columns + o);
            turned_scattered.iter().flat_map(move |&o| row(o))
        };
        let channel = |values: &[f32]| entries().map(|entry| values[entry]).collect::<Vec<f32>>();
        let (incident, scattered) = (self.scattered().clone(), self.incident().clone());
        let matrix = Self::new(incident, scattered, channel(self.values()))?;
        match self.chromatic() {
            Some([x, z]) => matrix.with_colour(channel(x), channel(z)),
            None => Ok(matrix),
        }
    }

    /// ½ ∫∫ |f − fᵀ| / ∫∫ f, in travel indexing: the share of light that differs where rows and columns are exchanged.
    ///
    /// `None` where nothing is scattered or the bases differ.
    pub fn asymmetry(&self) -> Option<f64> {
        let basis = self.incident();
        if basis != self.scattered() {
            return None;
        }
        let (values, n) = (self.values(), basis.directions());
        let omega: Vec<f64> = (0..n).map(|k| basis.projected_solid_angle(k)).collect();
        let (mut differs, mut total) = (0.0, 0.0);
        for (i, row) in values.chunks(n).enumerate() {
            for (o, &v) in row.iter().enumerate() {
                let weight = omega[i] * omega[o];
                total += f64::from(v) * weight;
                differs += 0.5 * f64::from((v - values[o * n + i]).abs()) * weight;
            }
        }
        (total > 0.0).then(|| differs / total)
    }
}

/// Of each patch the one on the other side of the normal.
fn turned(basis: &KlemsBasis) -> Result<Vec<usize>> {
    if let Some(ring) = basis.rings().iter().find(|r| r.patches > 1 && r.patches % 2 == 1) {
        let text = format!(
            "{}: expected rings of an even number of patches, found {}",
            basis.name(),
            ring.patches
        );
        return Err(Error::argument(text));
    }
    let opposite = |k: usize| {
        let w = basis.centre(k);
        basis.index(DVec3::new(-w.x, -w.y, w.z)).unwrap_or(k)
    };
    Ok((0..basis.directions()).map(opposite).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::Ring;
    use crate::{Bsdf, Component, Lambertian, Metadata, Side};
    use bsdfkit_sphere::direction::from_degrees;

    /// Answers as the lone transmission does.
    #[test]
    fn the_other_way_is_what_a_lone_transmission_answers() {
        let (half, quarter) = (KlemsBasis::half(), KlemsBasis::quarter());
        let values = (0..77 * 41).map(|n| 0.01 + (n * 37 % 1001) as f32 * 1e-3).collect();
        let front = KlemsMatrix::new(half, quarter, values).unwrap();
        let back = front.reversed().unwrap();
        let of = |i, s, m| {
            let c = vec![Component::new(i, s, m)];
            Bsdf::new(Metadata::default(), c, Lambertian::default())
        };
        let lone = of(Side::Front, Side::Back, front);
        let stored = of(Side::Back, Side::Front, back);
        for n in 0..500 {
            let (a, b) = (f64::from(n * 17 % 89), f64::from(n * 29 % 87));
            let wi = -from_degrees(a, f64::from(n * 23));
            let wo = from_degrees(b, f64::from(n * 31 + 3));
            assert_eq!(lone.eval(wi, wo), stored.eval(wi, wo), "{wi} {wo}");
            assert!(lone.eval(wi, wo) > 0.0);
        }
    }

    #[test]
    fn odd_rings_are_refused() {
        let ring = |upper_degrees, patches| Ring { upper_degrees, patches };
        let odd = KlemsBasis::new("odd", vec![ring(30.0, 1), ring(90.0, 7)]).unwrap();
        let matrix = KlemsMatrix::new(odd.clone(), odd, vec![0.1; 64]).unwrap();
        assert!(matrix.reversed().unwrap_err().to_string().contains("found 7"));
    }
}
