//! What is said of a measurement.

use bsdfkit_measure::Measurement;

use super::report::{Energy, Report};

pub(super) fn examine_measurement(m: &Measurement, found: &mut Report) {
    let quality = m.quality();
    found.remarks.extend(quality.notes);
    found.remarks.extend(quality.scant.iter().map(|s| format!("{}: {s}", quality.component)));
    if let Err(few) = m.expect_enough() {
        found.faults.push(few.context(&quality.component).to_string());
    }
    let luminance = m.colorimetry.luminance_channel();
    // Of what was not seen all round, what was seen alone can be too much.
    let total = |k: usize| quality.incidences[k].hemispherical_at_least[luminance];
    let known = (0..m.incidences.len()).filter(|&k| total(k).is_finite());
    if let Some(k) = known.max_by(|&a, &b| total(a).total_cmp(&total(b))) {
        let place = quality.component.clone();
        let extrapolated = quality.incidences[k].extrapolated;
        found.energy.push(Energy { place, total: total(k), wi: m.incidences[k].wi, extrapolated });
    }
    let negatives: usize = quality.incidences.iter().map(|i| i.negatives).sum();
    if negatives > 0 {
        let text =
            format!("{}: {negatives} of {} values negative", quality.component, quality.points);
        found.remarks.push(text);
    }
    let holes = quality.incidences.iter().flat_map(|i| &i.holes).filter(|h| !h.retro_reflection);
    if let Some(h) = holes.max_by(|a, b| a.radius_degrees.total_cmp(&b.radius_degrees)) {
        found.remarks.push(format!(
            "{}: nothing measured within {:.1} degrees of theta {:.0} phi {:.0}",
            quality.component, h.radius_degrees, h.theta_degrees, h.phi_degrees
        ));
    }
}
