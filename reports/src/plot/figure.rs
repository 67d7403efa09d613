//! Which pictures stand together: panels above one abscissa.

use procedures::trace::Plot;

/// A picture with its further panels.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure<'a> {
    panels: Vec<&'a Plot>,
}

impl<'a> Figure<'a> {
    /// A picture alone.
    pub fn of(plot: &'a Plot) -> Self {
        Self { panels: vec![plot] }
    }

    /// The figures of a procedure in the order of their first pictures; panels in the order of the list.
    ///
    /// A panel of a picture that is not there, or of another panel, is a figure of its own: nothing is lost.
    pub fn all(plots: &'a [Plot]) -> Vec<Self> {
        let head_of = |panel: &Plot| {
            plots.iter().position(|head| head.panel_of.is_none() && Some(&head.id) == panel.panel_of.as_ref())
        };
        let mut figures: Vec<(usize, Self)> = Vec::new();
        for (i, plot) in plots.iter().enumerate() {
            if head_of(plot).is_none() {
                figures.push((i, Self::of(plot)));
            }
        }
        for plot in plots {
            let Some(head) = head_of(plot) else { continue };
            if let Some((_, figure)) = figures.iter_mut().find(|(i, _)| *i == head) {
                figure.panels.push(plot);
            }
        }
        figures.into_iter().map(|(_, figure)| figure).collect()
    }

    /// The picture on top.
    pub fn head(&self) -> &'a Plot {
        self.panels[0]
    }

    /// All panels from top to bottom; at least one.
    pub fn panels(&self) -> &[&'a Plot] {
        &self.panels
    }
}
