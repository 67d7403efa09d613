//! Zooming into figures: their data, and the script that draws it. Both stand in the page.

use crate::markup::Markup;
use crate::plot::{Figure, zoom};

/// uPlot, and the licence that its copies have to carry.
const UPLOT: &str = include_str!("../../assets/uplot.min.js");
const UPLOT_LICENSE: &str = include_str!("../../assets/uplot.LICENSE");
const PAINT: &str = include_str!("../../assets/paint.js");
const SCRIPT: &str = include_str!("../../assets/zoom.js");

/// Style of uPlot.
pub(super) const STYLE: &str = include_str!("../../assets/uplot.min.css");

/// The data of a figure, inside of it.
pub(super) fn data(m: &mut Markup, figure: &Figure<'_>) {
    m.open("script", &[("type", "application/json")]);
    m.verbatim(&zoom::data(figure));
    m.close();
}

/// What draws the data when somebody asks for it; once a page, behind all figures.
pub(super) fn script(m: &mut Markup) {
    m.open("script", &[]);
    m.verbatim(&format!("\n/*!\n{}\n*/\n{}\n{PAINT}{SCRIPT}", UPLOT_LICENSE.trim(), UPLOT.trim()));
    m.close();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_script_neither_ends_its_element_nor_builds_code_nor_fetches() {
        for text in [UPLOT, UPLOT_LICENSE, PAINT, SCRIPT] {
            for bad in ["</script", "<!--", "eval(", "new Function", "fetch(", "XMLHttpRequest", "import("] {
                assert!(!text.contains(bad), "{bad}");
            }
        }
        assert!(!UPLOT_LICENSE.contains("*/"));
    }

    #[test]
    fn our_script_sets_text_never_markup() {
        for bad in ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "setAttribute(\"on"] {
            assert!(!SCRIPT.contains(bad) && !PAINT.contains(bad), "{bad}");
        }
    }
}
