//! A chart of times over counts, both logarithmic: what is linear is a line of slope 1.
use std::error::Error;
use std::ops::Range;
use std::path::Path;

use plotters::prelude::*;

/// A chart of milliseconds over counts, with logarithmic axes.
#[derive(Debug)]
pub struct LogChart<'a> {
    /// Above the chart.
    pub caption: &'a str,
    /// Name of the counts along x.
    pub counted: &'a str,
    /// Counts that the chart spans.
    pub counts: Range<f64>,
    /// Milliseconds that the chart spans.
    pub milliseconds: Range<f64>,
    /// Counts from and to which a linear cost is drawn, and its milliseconds a count.
    pub linear: ([f64; 2], f64),
}

impl LogChart<'_> {
    /// Writes an SVG of named lines of (count, milliseconds).
    ///
    /// # Errors
    /// A chart that cannot be drawn or written.
    pub fn write(
        self,
        path: &Path,
        lines: &[(String, Vec<(f64, f64)>)],
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        let root = SVGBackend::new(path, (900, 560)).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(self.caption, ("sans-serif", 20))
            .margin(16)
            .x_label_area_size(44)
            .y_label_area_size(64)
            .build_cartesian_2d(self.counts.log_scale(), self.milliseconds.log_scale())?;
        chart
            .configure_mesh()
            .x_desc(self.counted)
            .y_desc("ms")
            .draw()?;
        for (k, (name, points)) in lines.iter().enumerate() {
            let color = Palette99::pick(k).to_rgba();
            chart
                .draw_series(LineSeries::new(
                    points.iter().copied(),
                    color.stroke_width(2),
                ))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 24, y)], color.stroke_width(2))
                });
            chart.draw_series(points.iter().map(|p| Circle::new(*p, 3, color.filled())))?;
        }
        let (ends, each) = self.linear;
        chart
            .draw_series(LineSeries::new(
                ends.map(|n| (n, n * each)),
                BLACK.mix(0.4).stroke_width(1),
            ))?
            .label("linear")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 24, y)], BLACK.mix(0.4)));
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .border_style(BLACK.mix(0.3))
            .background_style(WHITE)
            .draw()?;
        root.present()?;
        Ok(())
    }
}
