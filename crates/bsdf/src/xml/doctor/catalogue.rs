//! Every kind of finding: the one place that says what a program does about it.

use super::kind::How::{Limited, Refuses, Wrong};
use super::kind::Mends::{Always, Asked, For, Never};
use super::kind::{Harm, How, Kind, Mends};
use super::program::Program::{self, EnergyPlus, Frads, Honeybee, Mitsuba, Radiance, Window};

const ALL: &[Program] = &Program::ALL;
/// WINDOW's engine, and frads, whose glazing systems are that engine's.
const ENGINE: &[Program] = &[Window, Frads];
const RADIANCE: &[Program] = &[Radiance, Frads, Honeybee];

const fn harm(programs: &'static [Program], how: How, text: &'static str) -> Harm {
    Harm { programs, how, text }
}

const fn of(
    code: &'static str,
    title: &'static str,
    harms: &'static [Harm],
    mends: Mends,
    remedy: &'static str,
) -> Kind {
    Kind { code, title, harms, remedy, mends }
}

/// All kinds, by family: the file, its words, its description, its blocks, its form, its light.
pub static KINDS: &[Kind] = &[
    // the file
    of(
        "web-page",
        "a web page saved under the file's name",
        &[harm(ALL, Refuses, "refuses it: there is no BSDF in it")],
        Never,
        "download the file itself, not the page that shows it: on GitHub the button Raw",
    ),
    of(
        "other-format",
        "a file of another format",
        &[harm(ALL, Refuses, "refuses it")],
        Never,
        "see what is said of that format",
    ),
    of(
        "unreadable",
        "text or numbers that cannot be read",
        &[harm(ALL, Wrong, "refuses it, or takes what it finds there without a word")],
        Never,
        "make the file anew with the program that wrote it, or fetch it again",
    ),
    of(
        "before-declaration",
        "text before the XML declaration",
        &[harm(ENGINE, Refuses, "refuses it; Radiance reads it")],
        Always("left out"),
        "delete what stands before the first `<`",
    ),
    of(
        "outside-text",
        "text after the end of the document",
        &[],
        Always("left out"),
        "delete what stands after the last `>`: strict XML readers refuse the file",
    ),
    of(
        "encoding",
        "letters that are not in UTF-8",
        &[harm(ENGINE, Refuses, "cannot decode it, or ends")],
        Always("written in UTF-8"),
        "save the file in UTF-8",
    ),
    of(
        "line-breaks",
        "elements that do not begin a line",
        &[harm(
            &[Honeybee],
            Refuses,
            "reads line by line and does not find the structure or the basis",
        )],
        Always("written on lines of their own"),
        "begin a line with `<IncidentDataStructure>` and with `<AngleBasisName>`",
    ),
    of(
        "late-structure",
        "the structure stands past line 2000",
        &[harm(&[Honeybee], Refuses, "gives up looking for it")],
        Never,
        "shorten what stands before it, as a rule the geometry",
    ),
    // its words
    of(
        "padded-label",
        "white space around a wavelength or a direction",
        &[harm(
            RADIANCE,
            Wrong,
            "does not know the block and loads what is left: black without a word",
        )],
        Always("white space taken away"),
        "write the words without blanks and line ends around them",
    ),
    of(
        "padded-keyword",
        "white space around a word that decides how the file is read",
        &[harm(RADIANCE, Refuses, "refuses it")],
        Always("white space taken away"),
        "write the words without blanks and line ends around them",
    ),
    of(
        "cie-y",
        "the visible band called CIE-Y",
        &[
            harm(&[Radiance, Honeybee], Wrong, "does not know the band: black without a word"),
            harm(ENGINE, Refuses, "refuses the file for any band but Visible and Solar"),
        ],
        Always("called Visible"),
        "call it Visible",
    ),
    of(
        "rows",
        "structure Rows: incident directions as text rows",
        &[
            harm(ENGINE, Wrong, "reads it as Columns: every matrix transposed without a word"),
            harm(&[Honeybee], Refuses, "knows Columns and trees only"),
        ],
        Always("written as Columns"),
        "write Columns, the matrices transposed",
    ),
    of(
        "separators",
        "values parted by line ends, tabs or several blanks",
        &[harm(
            ENGINE,
            Wrong,
            "parts them at one character alone and loses some, or refuses the file",
        )],
        Always("parted by commas"),
        "write a comma after each value",
    ),
    // its description
    of(
        "no-description",
        "no name, maker or thickness",
        &[harm(ENGINE, Refuses, "refuses the file, or ends")],
        Always("placeholders written, called so in a comment"),
        "write Name, Manufacturer and Thickness; `bsdf convert` has options for them",
    ),
    of(
        "no-thermal-data",
        "no conductivity, emissivities or infrared transmittance",
        &[harm(ENGINE, Limited, "reads it, but has no U-value and no SHGC")],
        For,
        "write them (`bsdf convert --property FIELD=VALUE`); placeholders are called so in the file",
    ),
    of(
        "thickness-unit",
        "a thickness in another unit than metres or millimetres",
        &[
            harm(&[Window], Wrong, "takes the number as metres, whatever the unit"),
            harm(&[Frads], Wrong, "takes the number as millimetres, whatever the unit, metres too"),
        ],
        Always("written in metres"),
        "write it in metres; for frads in millimetres",
    ),
    of(
        "no-size",
        "no width or height",
        &[harm(
            &[Radiance],
            Limited,
            "renders it, but pkgBSDF makes no pane of it: zero width or height",
        )],
        Always("placeholders written, called so in a comment"),
        "write Width and Height (`bsdf convert --width --height`)",
    ),
    // its blocks
    of(
        "no-visible",
        "no visible band",
        &[
            harm(RADIANCE, Wrong, "loads it: black without a word"),
            harm(&[Window, EnergyPlus, Mitsuba], Refuses, "has no visible light in it"),
        ],
        Never,
        "measure or compute the band Visible",
    ),
    of(
        "no-solar",
        "no band Solar",
        &[
            harm(ENGINE, Refuses, "refuses a glazing system with it"),
            harm(&[EnergyPlus], Refuses, "wants solar beside visible properties"),
        ],
        For,
        "measure it, or let Visible stand for it, called so in the file: `--fix --for window`",
    ),
    of(
        "missing-directions",
        "not all four directions",
        &[
            harm(ENGINE, Refuses, "refuses a glazing system with it"),
            harm(
                &[EnergyPlus],
                Refuses,
                "wants transmission from outside and reflection of inside",
            ),
        ],
        For,
        "measure them; a transmission is the other one reversed, a reflection that nobody knows 0: `--fix --for window`",
    ),
    of(
        "further-bands",
        "bands beside Visible and Solar, colour among them",
        &[harm(ENGINE, Refuses, "refuses the whole file")],
        For,
        "keep a copy without them for that program: `--fix --for window`",
    ),
    of(
        "duplicate-block",
        "two blocks of one band and direction",
        &[harm(ALL, Wrong, "takes the last one without a word")],
        Always("the last one kept"),
        "delete the wrong one; the corrected copy keeps the last",
    ),
    of(
        "fractional",
        "shares of light instead of values in 1/sr",
        &[harm(&[Radiance, Window, Frads, Honeybee], Wrong, "reads the shares as 1/sr")],
        Always("divided by the projected solid angle of the scattered patch"),
        "divide them by the projected solid angle of the scattered patch",
    ),
    of(
        "dummy-transmission",
        "a transmission that is 0 throughout, beside one that is not",
        &[
            harm(
                &[Window, EnergyPlus, Frads],
                Wrong,
                "takes it as measured: no light passes that way",
            ),
            harm(&[Radiance, Honeybee], Limited, "reverses the other one"),
        ],
        Always("the other direction reversed"),
        "write the other direction reversed",
    ),
    of(
        "dummy-loses-floor",
        "a transmission that is 0 throughout, beside one that is nowhere 0",
        &[harm(
            &[Radiance, Honeybee],
            Wrong,
            "reverses the other one without its least value, which it takes for Lambertian: light is lost",
        )],
        Always("the other direction reversed"),
        "write the other direction reversed",
    ),
    of(
        "dummy-block",
        "a direction that is 0 throughout",
        &[harm(ALL, Limited, "takes it as measured: nothing is scattered that way")],
        Never,
        "measure it, if it is a dummy",
    ),
    of(
        "dummy-band",
        "a band that is 0 throughout, beside a visible one that is not",
        &[harm(&[Window, EnergyPlus, Frads], Wrong, "takes it as measured: no solar gain")],
        Always("left out"),
        "as where there is none",
    ),
    of(
        "dummy-colour",
        "a colour that is 0 throughout",
        &[harm(RADIANCE, Wrong, "gives it the colour of no light")],
        Always("left out"),
        "delete the blocks: grey is right where no colour is known",
    ),
    of(
        "half-colour",
        "a colour of which one part is missing or has another basis",
        &[],
        Always("left out"),
        "write both parts on the basis of Visible, or none: read as grey",
    ),
    of(
        "band-not-read",
        "a band that cannot be read",
        &[harm(ENGINE, Refuses, "refuses the file")],
        Never,
        "make the band anew, or delete it",
    ),
    of(
        "negative",
        "negative values",
        &[harm(ALL, Wrong, "takes them as they are, or as 0")],
        Always("written as 0"),
        "noise about 0: write 0",
    ),
    of("further-layers", "more than one layer", &[], Never, "one file a layer: the first is read"),
    // its form
    of(
        "tree",
        "a tensor tree",
        &[
            harm(ENGINE, Refuses, "reads Klems Full only"),
            harm(&[EnergyPlus], Refuses, "has matrices only"),
        ],
        For,
        "make a matrix of it: `bsdf convert FILE --for window`",
    ),
    of(
        "not-klems-full",
        "a matrix on another basis than Klems Full",
        &[harm(ENGINE, Refuses, "reads Klems Full only")],
        For,
        "convert it: `bsdf convert FILE --for window`",
    ),
    of(
        "half-77",
        "Klems Half with 77 directions",
        &[harm(&[Frads], Refuses, "knows matrices of 145, 73 and 41 directions")],
        For,
        "take Klems Full: `bsdf convert FILE --to klems-full`",
    ),
    of(
        "half-73",
        "Klems Half with 73 directions",
        &[harm(
            &[Radiance, Honeybee],
            Refuses,
            "has had 77 since 2022 and refuses 73 under that name",
        )],
        Always("the basis given a name of its own"),
        "give the basis, with its rings, a name of its own",
    ),
    of(
        "other-rings",
        "a known basis with rings of its own",
        &[harm(
            RADIANCE,
            Wrong,
            "takes the rings that it knows under that name, or refuses the file",
        )],
        Always("the basis given a name of its own"),
        "give the basis a name of its own",
    ),
    of(
        "incomplete-basis",
        "a basis that ends before 90 degrees",
        &[harm(RADIANCE, Wrong, "takes what is scattered as perfectly diffuse")],
        Never,
        "write a basis whose last ring ends at 90 degrees",
    ),
    of(
        "lone-isotropic-tree",
        "an isotropic tree of one transmission",
        &[harm(
            &[Radiance, Honeybee],
            Limited,
            "seen from the side to which it scatters it is lit by sources alone, not by the sky",
        )],
        Never,
        "put its other side there, or write the other direction, too: `bsdf convert FILE --for radiance`",
    ),
    of(
        "transmits",
        "transmission",
        &[
            harm(
                &[Mitsuba],
                Limited,
                "shows it by our plugin alone: RGL's tables hold reflection of the front",
            ),
            harm(
                &[Radiance, Honeybee],
                Limited,
                "lets sun and view rays through as if nothing were there if the BSDF primitive has a thickness other than 0",
            ),
        ],
        Never,
        "Mitsuba: `import bsdfkit.mitsuba`; Radiance: thickness 0, or aBSDF",
    ),
    // its light
    of(
        "energy",
        "more light scattered than arrives",
        &[harm(ALL, Wrong, "takes it without a word: light grows with every bounce")],
        Always("scaled down to what arrives"),
        "up to 20 % too much is scaled down to what arrives; more is a fault of units: make the file anew",
    ),
    of(
        "band-energy",
        "more light of a further band scattered than arrives",
        &[harm(&[Window, EnergyPlus, Frads], Wrong, "takes it without a word")],
        Always("scaled down to what arrives"),
        "see whether a block stands under the wrong direction; up to 20 % too much is scaled down",
    ),
    of(
        "exchanged-sides",
        "reflection of front and back exchanged against transmission",
        &[harm(
            ALL,
            Wrong,
            "adds to one side's transmission the other side's reflection: more light than arrives",
        )],
        Always("Reflection Front and Reflection Back exchanged"),
        "exchange Reflection Front and Reflection Back",
    ),
    of(
        "reflects-outside",
        "reflection of the exterior alone",
        &[harm(ALL, Limited, "shows black from inside, as WINDOW's front is the exterior")],
        Asked("front and back exchanged"),
        "if the specimen's front was meant: `--fix --also reflects-outside` exchanges the sides",
    ),
    of(
        "not-reciprocal",
        "values that differ when light goes back, beyond noise",
        &[harm(ALL, Limited, "answers by the direction in which it happens to trace light")],
        Asked("both ways averaged"),
        "if it is noise: `--fix --also not-reciprocal` averages both ways; totals change",
    ),
    of(
        "dark",
        "nothing is scattered",
        &[harm(ALL, Wrong, "shows black")],
        Never,
        "make the file anew",
    ),
    of(
        "weak",
        "a direction that scatters less than 15 %",
        &[harm(
            &[Radiance, Honeybee],
            Limited,
            "takes it as perfectly diffuse when tracing rays, by -st .15",
        )],
        Never,
        "render with -st 0",
    ),
    of(
        "faint",
        "a direction that scatters less than 0.1 %",
        &[harm(&[Radiance, Honeybee], Limited, "drops it")],
        Never,
        "nothing: it is hardly seen",
    ),
    of(
        "asymmetric",
        "a transmission that differs from its transpose",
        &[harm(
            &[EnergyPlus],
            Limited,
            "transposes it for light of sky and ground; the beam is right",
        )],
        Never,
        "compare the beam's share only",
    ),
];

/// The kind of that code.
pub fn kind(code: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.code == code)
}
