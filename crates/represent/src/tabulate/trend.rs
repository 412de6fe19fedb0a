//! What varies within a node as smooth lookup can follow it.

/// Mean, slopes and twists over a cell of up to four dimensions.
///
/// Convention: coefficient i is that of the product of the places, −1 to 1, in the dimensions whose bits
/// are set in i.
pub(super) struct Trend([f64; 16]);

impl Trend {
    pub(super) fn even(value: f64) -> Self {
        let mut coefficients = [0.0; 16];
        coefficients[0] = value;
        Self(coefficients)
    }

    /// From the means of 8 or 16 children; bit d of a child's number is its half of dimension d.
    pub(super) fn of_children(means: &[f32]) -> Self {
        let mut trend = [0.0; 16];
        for (to, mean) in trend.iter_mut().zip(means) {
            *to = f64::from(*mean);
        }
        for d in 0..means.len().ilog2() {
            for low in (0..means.len()).filter(|i| i >> d & 1 == 0) {
                let (below, above) = (trend[low], trend[low | 1 << d]);
                // Children's centres are half way between centre and rim.
                (trend[low], trend[low | 1 << d]) = (0.5 * (below + above), above - below);
            }
        }
        for (i, coefficient) in trend.iter_mut().enumerate() {
            // Of three dimensions and four it is as likely noise.
            if i.count_ones() > 2 {
                *coefficient = 0.0;
            }
        }
        Self(trend)
    }

    /// At a place, −1 to 1 in each dimension; 0 at least.
    pub(super) fn at(&self, place: [f32; 4]) -> f64 {
        let mut sum = self.0;
        for d in (0..4).rev() {
            for i in 0..1 << d {
                sum[i] += sum[i + (1 << d)] * f64::from(place[d]);
            }
        }
        sum[0].max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_and_saddles_are_followed() {
        let f = |[x, y, z, w]: [f32; 4]| 4.0 + 0.5 * x - y + 0.25 * w + x * z - 0.5 * y * w;
        let means: [f32; 16] =
            std::array::from_fn(|c| f(std::array::from_fn(|d| (c >> d & 1) as f32 - 0.5)));
        let trend = Trend::of_children(&means);
        for place in [[0.0; 4], [1.0, -1.0, 1.0, -0.25], [0.5, 0.0, -1.0, 1.0]] {
            assert!((trend.at(place) - f64::from(f(place))).abs() < 1e-6);
        }
        // Rank 3: eight children.
        let trend = Trend::of_children(&[1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]);
        assert_eq!(trend.at([1.0, 0.3, -0.7, 0.0]), 2.5);
        assert_eq!(trend.at([-3.5, 0.0, 0.0, 0.0]), 0.0);
        assert_eq!(Trend::even(0.7).at([1.0; 4]), 0.7);
    }
}
