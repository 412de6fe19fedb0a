//! Files of formats that hold no BSDF to be opened: named, with what to do instead.

use std::fmt;
use std::path::Path;

use encoding_rs::WINDOWS_1252;

use crate::encoding::wide;
use crate::{Error, Result};

/// Bytes of a file that [`recognise`] looks at: comments of several pages may come before the first keyword.
pub const HEAD: u64 = 1 << 16;

/// A measurement in a format of others. This crate only knows it; `bsdfkit_measure` reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// RGL's tensors: reflection over warped half vectors.
    Rgl,
    /// MERL: reflection over half and difference angles.
    Merl,
    /// Zemax: angles about the specular direction.
    Zemax,
    /// LightTools: angles about the normal.
    LightTools,
    /// ASTM E1392 and E2387.
    Astm,
    /// FRED's tables, RPC Photonics' among them.
    Fred,
    /// Cornell's gonioreflectometer.
    Cornell,
    /// ALTA.
    Alta,
    /// The universal BRDF data format of the BiRD project.
    Bird,
}

impl Measured {
    /// What is known of the format.
    pub fn foreign(self) -> &'static Foreign {
        let is = |f: &&Foreign| f.measured() == Some(self);
        FORMATS.iter().find(is).expect("each has a line in the table")
    }
}

/// A format that [`Bsdf::open`](crate::Bsdf::open) does not read.
#[derive(Debug)]
pub struct Foreign {
    /// With its article: "a Zemax BSDF file".
    pub name: &'static str,
    way_out: WayOut,
    signs: &'static [Sign],
}

/// What its owner can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WayOut {
    /// It holds a measurement that can be fitted.
    Fit(Measured),
    /// It holds a BSDF.
    Export,
    /// It holds other files.
    Unpack,
    /// It holds a sheet of cells.
    SaveAsCsv,
    /// It holds something else than the file that was asked for.
    Fetch,
    /// It holds the light of a luminaire.
    Luminaire,
    /// It holds reflectances and transmittances.
    Totals,
    /// It holds nothing of use.
    Nothing,
}
use WayOut::{Export, Fetch, Fit, Luminaire, Nothing, SaveAsCsv, Totals, Unpack};

/// How a format is known. No sign fits a file that is read.
#[derive(Clone, Copy, Debug)]
enum Sign {
    /// The first bytes.
    Bytes(&'static [u8]),
    /// The first bytes, and others somewhere after them.
    Holds(&'static [u8], &'static [u8]),
    /// How the first line that is not blank begins, in capitals or not.
    Begins(&'static str),
    /// Each is the first word of a line that is no comment.
    Words(&'static [&'static str]),
    /// A line, up to blanks around it.
    Line(&'static str),
    /// None of these.
    Test(fn(&Head<'_>) -> bool),
}
use Sign::{Begins, Bytes, Holds, Line, Test, Words};

/// All formats; of two that fit, the first is named.
const FORMATS: &[Foreign] = &[
    // measurements of others
    of(
        "an RGL tensor file (Mitsuba's measured BSDF)",
        Fit(Measured::Rgl),
        &[Bytes(b"tensor_file\0")],
    ),
    of("a MERL BRDF file", Fit(Measured::Merl), &[Test(is_merl)]),
    of("a Zemax BSDF file", Fit(Measured::Zemax), &[Words(&["AngleOfIncidence", "ScatterRadial"])]),
    of(
        "a LightTools BSDF file",
        Fit(Measured::LightTools),
        &[Words(&["ScatterAzimuth", "ScatterRadial"])],
    ),
    of("an ASTM E1392 or E2387 scatter file", Fit(Measured::Astm), &[Test(is_astm)]),
    of(
        "an RPC Photonics or FRED BSDF file",
        Fit(Measured::Fred),
        &[Begins("!!"), Begins("type bsdf_data")],
    ),
    of("a Cornell BRDF file", Fit(Measured::Cornell), &[Line("# num wls")]),
    of("an ALTA data file", Fit(Measured::Alta), &[Test(|h| h.word_of_line("#PARAM_IN"))]),
    of(
        "a BRDF file of the BiRD project (universal BRDF data format)",
        Fit(Measured::Bird),
        &[Test(is_bird)],
    ),
    // BSDFs of others
    of("an Integra DDR or DDT file", Export, &[Words(&["TypeColorModel"])]),
    of("an SSDD file (Surface Scattering Distribution Data)", Export, &[Words(&["PARAM_TYPE"])]),
    of("an Ansys Speos (OPTIS) surface file", Export, &[Begins("OPTIS")]),
    of("an NVIDIA MDL measured BSDF", Export, &[Bytes(b"NVIDIA ARC MBSDF")]),
    // photometry
    of("an IES photometry file", Luminaire, &[Begins("IESNA"), Test(is_ies)]),
    of("an EULUMDAT photometry file", Luminaire, &[Test(is_eulumdat)]),
    // containers
    of(
        "an Excel workbook",
        SaveAsCsv,
        &[Holds(b"PK\x03\x04", b"xl/"), Bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")],
    ),
    of(
        "an OpenDocument spreadsheet",
        SaveAsCsv,
        &[Holds(b"PK\x03\x04", b"opendocument.spreadsheet")],
    ),
    of("a ZIP archive", Unpack, &[Bytes(b"PK\x03\x04"), Bytes(b"PK\x05\x06")]),
    of("a gzip file", Unpack, &[Bytes(b"\x1f\x8b\x08")]),
    of("a bzip2 file", Unpack, &[Holds(b"BZh", b"1AY&SY")]),
    of("an xz file", Unpack, &[Bytes(b"\xfd7zXZ\0")]),
    of("a Zstandard file", Unpack, &[Bytes(b"\x28\xb5\x2f\xfd")]),
    of("a 7-Zip archive", Unpack, &[Bytes(b"7z\xbc\xaf\x27\x1c")]),
    of("a RAR archive", Unpack, &[Bytes(b"Rar!\x1a\x07")]),
    of("a tar archive", Unpack, &[Test(|h| h.bytes.get(257..262) == Some(b"ustar"))]),
    of(
        "an HDF5 file (AxF, MATLAB 7.3, NetCDF)",
        Export,
        &[Bytes(b"\x89HDF\r\n\x1a\n"), Bytes(b"MATLAB 7.3 MAT-file")],
    ),
    of("a MATLAB file", Export, &[Bytes(b"MATLAB 5.0 MAT-file")]),
    of("a NumPy array", Export, &[Bytes(b"\x93NUMPY")]),
    of("a Parquet file", Export, &[Bytes(b"PAR1")]),
    of("an SQLite database", Export, &[Bytes(b"SQLite format 3\0")]),
    // what stands in for a file
    of(
        "a web page (HTML)",
        Fetch,
        &[
            Begins("<!doctype html"),
            Begins("<html"),
            Begins("<head"),
            Begins("<body"),
            Begins("<script"),
        ],
    ),
    of("a pointer of Git LFS", Fetch, &[Begins("version https://git-lfs.github.com/")]),
    // pictures, papers, scenes
    of("a PDF document", Nothing, &[Bytes(b"%PDF")]),
    of("a PostScript file", Nothing, &[Bytes(b"%!PS")]),
    of("an RTF document", Nothing, &[Bytes(b"{\\rtf")]),
    of("a PNG image", Nothing, &[Bytes(b"\x89PNG")]),
    of("a JPEG image", Nothing, &[Bytes(b"\xff\xd8\xff")]),
    of("a GIF image", Nothing, &[Bytes(b"GIF87a"), Bytes(b"GIF89a")]),
    of("a TIFF image", Nothing, &[Bytes(b"II*\0"), Bytes(b"MM\0*")]),
    of("an OpenEXR image", Nothing, &[Bytes(b"\x76\x2f\x31\x01")]),
    of("an SVG image", Nothing, &[Begins("<svg")]),
    of(
        "a Radiance picture",
        Nothing,
        &[Holds(b"#?RADIANCE", b"FORMAT=32-bit_rle"), Bytes(b"#?RGBE")],
    ),
    of("a Radiance octree", Nothing, &[Holds(b"#?RADIANCE", b"FORMAT=Radiance_octree")]),
    of(
        "a Radiance scene",
        Nothing,
        &[Test(|h| h.first_word("void")), Begins("!gen"), Begins("!xform")],
    ),
    of("a PLY mesh", Nothing, &[Line("ply")]),
    of("an STL mesh", Nothing, &[Begins("solid ")]),
    of("a Wavefront OBJ mesh", Nothing, &[Words(&["v", "f"]), Words(&["mtllib"])]),
    of("a Wavefront MTL file", Nothing, &[Words(&["newmtl"])]),
    of("a glTF scene", Nothing, &[Bytes(b"glTF")]),
    of("optical data of BED-JSON", Totals, &[Test(is_bed)]),
    of("a JSON file", Export, &[Begins("{"), Begins("[")]),
];

const fn of(name: &'static str, way_out: WayOut, signs: &'static [Sign]) -> Foreign {
    Foreign { name, way_out, signs }
}

/// What a file that starts with `head` (up to [`HEAD`] bytes) is, if [`Bsdf::open`](crate::Bsdf::open) does not read it.
pub fn recognise(head: &[u8]) -> Option<&'static Foreign> {
    let head = Head::new(head);
    FORMATS.iter().find(|f| f.signs.iter().any(|s| s.fits(&head)))
}

/// Refuses a file that starts with `head` if [`recognise`] knows what it is.
///
/// Errors: format, saying what to do.
pub fn refuse(head: &[u8]) -> Result<()> {
    recognise(head).map_or(Ok(()), |found| Err(found.refused()))
}

impl Foreign {
    /// Which measurement it is, if it can be fitted.
    pub fn measured(&self) -> Option<Measured> {
        match self.way_out {
            Fit(measured) => Some(measured),
            _ => None,
        }
    }

    /// The error where something else was expected.
    pub fn refused(&self) -> Error {
        Error::format(self.to_string())
    }

    /// Whether it may lie in a folder of measurements without being one of them: all but what stands in for a file
    /// that is not there, unless it is a web page by name, too.
    pub fn may_lie_beside(&self, path: &Path) -> bool {
        let suffix = path.extension().unwrap_or_default();
        self.way_out != Fetch || ["html", "htm"].iter().any(|s| suffix.eq_ignore_ascii_case(s))
    }
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, .. } = self;
        match self.way_out {
            Fit(_) => write!(
                f,
                "looks like {name}: a measurement, where a BSDF is expected; `bsdf fit` makes one of it"
            ),
            Export => write!(
                f,
                "looks like {name}, which bsdfkit does not read yet: export it as a table with the columns theta_i, \
                 phi_i, theta_o, phi_o, value (degrees; f in 1/sr without cosine), or as BSDF XML"
            ),
            Unpack => write!(f, "looks like {name}: unpack it and give the files in it"),
            SaveAsCsv => write!(
                f,
                "looks like {name}: save the sheet as CSV with the columns theta_i, phi_i, theta_o, phi_o, value \
                 (degrees; f in 1/sr without cosine)"
            ),
            Fetch => write!(f, "looks like {name}, not what it stands for: fetch the file itself"),
            Luminaire => write!(
                f,
                "looks like {name}: the light of a luminaire; expected a measurement or BSDF of a surface"
            ),
            Totals => write!(
                f,
                "looks like {name}: totals and names, no values of f; a catalogue reads it beside a BSDF of the same name \
                 (`bsdf catalog build`)"
            ),
            Nothing => write!(f, "looks like {name}: expected a measurement or BSDF of a surface"),
        }
    }
}

/// The start of a file.
struct Head<'b> {
    bytes: &'b [u8],
    text: String,
    /// The lines that do not begin with a number: few in a measurement.
    words: String,
    /// XML holds anything, geometry and programs of others among it: how it begins decides.
    markup: bool,
}

impl<'b> Head<'b> {
    fn new(bytes: &'b [u8]) -> Self {
        let bytes = &bytes[..bytes.len().min(HEAD as usize)];
        let (encoding, mark) = wide(bytes).unwrap_or((WINDOWS_1252, 0));
        let text = encoding.decode_without_bom_handling(&bytes[mark..]).0;
        let text = text.strip_prefix("ï»¿").unwrap_or(&text);
        let markup = ["<?xml", "<WindowElement"].iter().any(|m| text.contains(m))
            || text.trim_start().starts_with('<');
        // a page may come after a declaration
        let after = text.trim_start().strip_prefix("<?xml").and_then(|t| t.split_once("?>"));
        let text = after.map_or(text, |(_, after)| after).to_owned();
        let number = |l: &&str| l.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let lines = text.split(['\n', '\r']).map(str::trim);
        let words: Vec<&str> = lines.filter(|l| !l.is_empty() && !number(l)).collect();
        let words = words.join("\n");
        Self { bytes, text, words, markup }
    }

    /// Lines of words, without the blanks around them.
    fn lines(&self) -> impl Iterator<Item = &str> {
        self.words.lines()
    }

    /// Whether the first line that is no comment begins with `word`.
    fn first_word(&self, word: &str) -> bool {
        let line = self.lines().find(|l| !l.starts_with('#'));
        line.is_some_and(|l| l.split_whitespace().next() == Some(word))
    }

    /// Whether a line begins with `word`.
    fn word_of_line(&self, word: &str) -> bool {
        self.lines().any(|l| l.split_whitespace().next() == Some(word))
    }
}

impl Sign {
    fn fits(self, head: &Head<'_>) -> bool {
        match self {
            Bytes(start) => head.bytes.starts_with(start),
            Holds(start, later) => {
                head.bytes.starts_with(start)
                    && head.bytes.windows(later.len()).any(|part| part == later)
            }
            Begins(start) => {
                let text = head.text.trim_start();
                text.get(..start.len()).is_some_and(|t| t.eq_ignore_ascii_case(start))
            }
            Words(_) | Line(_) | Test(_) if head.markup => false,
            Words(words) => words.iter().all(|word| head.word_of_line(word)),
            Line(line) => head.lines().any(|l| l == line),
            Test(test) => test(head),
        }
    }
}

/// An object of JSON with the names that such a file must have, whichever of its two parts comes first.
fn is_bird(head: &Head<'_>) -> bool {
    let holds = |word: &str| head.text.contains(word);
    head.text.trim_start().starts_with('{')
        && holds("\"BRDF\"")
        && (holds("\"metadata\"") || holds("\"sr^-1\"") || holds("\"1/sr\""))
}

/// What every point of such a file has, and no table of ours.
fn is_bed(head: &Head<'_>) -> bool {
    let holds = |word: &str| head.text.contains(word);
    head.text.trim_start().starts_with('{')
        && ["\"dataPoints\"", "\"incidence\"", "\"emergence\""].into_iter().all(holds)
}

/// The three counts of a table over half and difference angles.
fn is_merl(head: &Head<'_>) -> bool {
    let count = |k: usize| {
        head.bytes.get(4 * k..4 * k + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    matches!([count(0), count(1), count(2)], [Some(90), Some(90), Some(180 | 360)])
}

/// The line that names the variables.
fn is_astm(head: &Head<'_>) -> bool {
    head.lines().any(|line| {
        line.strip_prefix("VARS")
            .is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
    }) || head.word_of_line("NUM_POINTS")
}

/// The line that every such file has, of the versions without a first line of their own too.
fn is_ies(head: &Head<'_>) -> bool {
    head.lines().any(|line| ["TILT=NONE", "TILT=INCLUDE"].contains(&line))
}

/// Six lines of one number each after the first: type, symmetry, two counts with their steps.
fn is_eulumdat(head: &Head<'_>) -> bool {
    let text = head.text.replace("\r\n", "\n");
    let lines: Vec<&str> = text.split(['\n', '\r']).map(str::trim).take(7).collect();
    let [_, numbers @ ..] = &lines[..] else { return false };
    let number = |line: &&str| line.replace(',', ".").parse::<f64>().ok();
    let Some(numbers) = numbers.iter().map(number).collect::<Option<Vec<f64>>>() else {
        return false;
    };
    let [kind, symmetry, planes, _, angles, _] = numbers[..] else { return false };
    let whole = |x: f64| x >= 1.0 && x.fract() == 0.0;
    [1.0, 2.0, 3.0].contains(&kind)
        && [0.0, 1.0, 2.0, 3.0, 4.0].contains(&symmetry)
        && whole(planes)
        && whole(angles)
}
