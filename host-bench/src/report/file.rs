//! The file of a picture: its form by the ending of its name, and its printed width.

use std::path::Path;
use std::sync::OnceLock;

use super::Picture;
use super::draw::draw;
use crate::method::Failure;

/// Endings of the forms in which a picture can be written.
pub(crate) const ENDINGS: &[&str] =
    if cfg!(feature = "images") { &["svg", "html", "pdf", "png"] } else { &["svg", "html"] };

/// Endings that need the feature `images`.
pub(crate) const OF_IMAGES: [&str; 2] = ["pdf", "png"];

/// Printed widths of pictures that are taken, in mm: a column of a journal to a page of A3.
const WIDTHS_MM: [f64; 2] = [80.0, 420.0];

/// A pixel of a picture with a printed width, in mm. The text of 18/1.24 pixels has 7 pt, each of 25.4/72 mm.
const PIXEL_MM: f64 = 7.0 * 25.4 / 72.0 / (18.0 / 1.24);

static WIDTH_MM: OnceLock<f64> = OnceLock::new();

/// Sets the printed width of all pictures of this process in mm. The first call counts.
pub(crate) fn set_width_mm(width: f64) {
    let _ = WIDTH_MM.set(width);
}

/// Reads a printed width, such as `85mm` or `3.3in`, in mm. Refuses widths outside 80 to 420 mm.
pub(crate) fn width_mm(text: &str) -> Result<f64, String> {
    let units = [("mm", 1.0), ("cm", 10.0), ("in", 25.4)];
    let parsed = units.into_iter().find_map(|(unit, factor)| {
        text.strip_suffix(unit)?.trim().parse::<f64>().ok().map(|number| factor * number)
    });
    let [least, most] = WIDTHS_MM;
    parsed
        .filter(|width| (least..=most).contains(width))
        .ok_or_else(|| format!("must be a length from {least}mm to {most}mm, in mm, cm or in"))
}

/// The width in pixels of a picture that has so many without a printed width.
pub(crate) fn columns(pixels: u32) -> u32 {
    WIDTH_MM.get().map_or(pixels, |width| (width / PIXEL_MM).round() as u32)
}

/// Draws charts as SVG, in the printed width if there is one, else in a width in pixels.
pub(crate) fn svg(
    pixels: u32,
    title: &str,
    charts: &[super::Chart],
    figure: Option<&(u32, String)>,
) -> Result<String, String> {
    let columns = columns(pixels);
    let text = draw(columns, title, charts, figure)?;
    let Some(width) = WIDTH_MM.get() else { return Ok(text) };
    let size = text.split_once("height=\"").and_then(|(_, rest)| rest.split_once('"')?.0.parse::<f64>().ok());
    let rows = size.ok_or("an SVG without a height")?;
    let [from, to] = [
        format!("<svg width=\"{columns}\" height=\"{rows}\""),
        format!("<svg width=\"{width}mm\" height=\"{:.2}mm\"", rows * PIXEL_MM),
    ];
    Ok(text.replacen(&from, &to, 1))
}

impl Picture {
    /// The bytes of a file of this name: a page if it ends in `.html`, with the feature `images` a PDF or a PNG too, else an SVG.
    pub(crate) fn of_file(&self, file: &Path) -> Result<Vec<u8>, Failure> {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("html") => self.page().map(String::into_bytes),
            #[cfg(feature = "images")]
            Some("pdf") => images::pdf(&self.svg()?),
            #[cfg(feature = "images")]
            Some("png") => images::png(&self.svg()?, WIDTH_MM.get().is_some()),
            _ => self.svg().map(String::into_bytes),
        }
    }
}

/// Why a picture cannot be drawn.
pub(super) fn refused(reason: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("the picture cannot be drawn: {reason}"))
}

/// Pictures as PDF and PNG, made from their SVG by the crates `svg2pdf` and `resvg`.
#[cfg(feature = "images")]
mod images {
    use resvg::tiny_skia::{Pixmap, Transform};
    use resvg::usvg::{Options, Tree, fontdb};
    use svg2pdf::{ConversionOptions, PageOptions};

    use super::{Failure, refused};

    /// Pixels of an inch of an SVG without units, as CSS has it.
    const DPI: f32 = 96.0;

    pub(super) fn pdf(svg: &str) -> Result<Vec<u8>, Failure> {
        let page = PageOptions { dpi: DPI };
        svg2pdf::to_pdf(&tree(svg)?, ConversionOptions::default(), page).map_err(refused)
    }

    /// Two pixels for each of the SVG, 300 an inch of one with a printed width.
    pub(super) fn png(svg: &str, is_printed: bool) -> Result<Vec<u8>, Failure> {
        let (tree, scale) = (tree(svg)?, if is_printed { 300.0 / DPI } else { 2.0 });
        let size = tree.size().to_int_size().scale_by(scale);
        let pixels = size.and_then(|size| Pixmap::new(size.width(), size.height()));
        let mut pixels = pixels.ok_or_else(|| refused("its size is none that a PNG can have"))?;
        resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
        pixels.encode_png().map_err(refused)
    }

    /// The drawing with its text in a font of the machine.
    fn tree(svg: &str) -> Result<Tree, Failure> {
        let mut options = Options { dpi: DPI, ..Options::default() };
        let fonts = options.fontdb_mut();
        fonts.load_system_fonts();
        let sans = fontdb::Query { families: &[fontdb::Family::SansSerif], ..fontdb::Query::default() };
        if fonts.query(&sans).is_none() {
            // Text in a family that is missing would be left out of the picture.
            let first = fonts.faces().find(|face| !face.monospaced).and_then(|face| face.families.first());
            let family =
                first.cloned().ok_or_else(|| refused("this machine has no font; .svg needs none"))?;
            fonts.set_sans_serif_family(family.0);
        }
        Tree::from_str(svg, &options).map_err(refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_printed_width_has_a_unit_and_bounds() {
        assert_eq!(width_mm("85mm"), Ok(85.0));
        assert!((width_mm("3.3in").expect("inches") - 83.82).abs() < 1e-9);
        for text in ["85", "mm", "79.9mm", "421mm", "nanmm", "85pt"] {
            assert!(width_mm(text).is_err_and(|reason| reason.contains("80mm to 420mm")), "{text}");
        }
    }
}
