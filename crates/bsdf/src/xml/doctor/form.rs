//! The form of the numbers: trees, bases, which sides there are.

use super::examine::Findings;
use crate::component::name_of_sides;
use crate::matrix::{KlemsBasis, KlemsMatrix};
use crate::tree::{Rank, TreeDistribution};
use crate::{Bsdf, Component, Side};

pub(super) fn look(bsdf: &Bsdf, found: &mut Findings) {
    let components = bsdf.components();
    let trees =
        || components.iter().filter_map(|c| c.distribution().downcast_ref::<TreeDistribution>());
    if let Some(tree) = trees().next() {
        let rank = match tree.luminance().rank() {
            Rank::Three => "TensorTree3",
            Rank::Four => "TensorTree4",
        };
        found.add("tree", "", format!("expected a matrix on Klems Full, found {rank}"));
    }
    let matrices = components.iter().filter_map(|c| c.distribution().downcast_ref::<KlemsMatrix>());
    let bases: Vec<&KlemsBasis> = matrices.flat_map(|m| [m.incident(), m.scattered()]).collect();
    let (full, half) = (KlemsBasis::full(), KlemsBasis::half());
    if let Some(other) = bases.iter().find(|b| ***b != full) {
        let text = format!(
            "expected Klems Full, found {} ({} directions)",
            other.name(),
            other.directions()
        );
        found.add("not-klems-full", "", text);
    }
    if bases.iter().any(|b| **b == half) {
        found.add("half-77", "", "expected 145, 73 or 41 directions, found 77");
    }
    let Some(transmission) = components.iter().find(|c| c.is_transmission()) else {
        outside_alone(components, found);
        return;
    };
    found.add("transmits", name(transmission), "light passes");
    if found.has("dummy-transmission") && transmission.floor().y > 0.0 {
        let text = format!(
            "nowhere below {:.4} 1/sr, the other direction a dummy",
            transmission.floor().y
        );
        found.add("dummy-loses-floor", name(transmission), text);
    }
    let lone = components.iter().filter(|c| c.is_transmission()).count() == 1;
    let tree = transmission.distribution().downcast_ref::<TreeDistribution>();
    if lone && tree.is_some_and(|t| t.luminance().rank() == Rank::Three) {
        let side = if transmission.scattered == Side::Front { "front" } else { "back" };
        found.add("lone-isotropic-tree", name(transmission), format!("seen from the {side}"));
    }
}

fn name(component: &Component) -> &'static str {
    name_of_sides(component.incident, component.scattered)
}

/// What only reflects, and only light from outside, shows black from the front.
fn outside_alone(components: &[Component], found: &mut Findings) {
    if let [one] = components
        && (one.incident, one.scattered) == (Side::Back, Side::Back)
    {
        let text = "expected Reflection Back, seen from the front, found Reflection Front alone";
        found.add("reflects-outside", name(one), text);
    }
}
