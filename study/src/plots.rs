//! Plots as SVG: lines, marks and error bars over linear or logarithmic axes, and pictures of the sheet.

use crate::Result;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::Path;

/// Colours that differ for colour-blind eyes too (Okabe and Ito), and four more for crowded plots.
pub const COLOURS: [RGBColor; 11] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(70, 70, 70),
    RGBColor(130, 60, 160),
    RGBColor(120, 80, 40),
    RGBColor(150, 170, 60),
    RGBColor(0, 0, 0),
];

const FONT: &str = "sans-serif";
const SIZE: (u32, u32) = (980, 560);
const GREY: RGBColor = RGBColor(150, 150, 150);

/// How a series is drawn.
#[derive(Clone, Copy, PartialEq)]
pub enum Style {
    /// A line.
    Line,
    /// A line with a mark at each point.
    Marked,
    /// A dashed line, for limits and references.
    Dashed,
    /// Marks without a line.
    Points,
    /// Small dots without a line, for very many points.
    Dots,
}

/// The scales of the axes.
#[derive(Clone, Copy, PartialEq)]
pub enum Axes {
    /// Both linear, y from 0.
    FromZero,
    /// Both logarithmic; points that are not positive are left out.
    Logarithmic,
}

/// Points with a name for the legend. Colours follow the order of the series.
pub struct Series {
    /// Text in the legend.
    pub name: String,
    /// Line or marks.
    pub style: Style,
    /// Points in the units of the axes.
    pub points: Vec<(f64, f64)>,
    /// Error bars: lower and upper end of y at each point. Empty for none.
    pub bars: Vec<(f64, f64)>,
}

impl Series {
    /// A series without error bars.
    pub fn new(name: impl Into<String>, style: Style, points: Vec<(f64, f64)>) -> Series {
        Series { name: name.into(), style, points, bars: Vec::new() }
    }
}

/// A vertical line at an event in time.
pub struct Mark {
    /// Where, in units of the x axis.
    pub at: f64,
    /// Text beside it.
    pub name: String,
}

/// One plot.
pub struct Plot<'a> {
    /// Heading.
    pub title: &'a str,
    /// Label of the x axis, with its unit.
    pub x: &'a str,
    /// Label of the y axis, with its unit.
    pub y: &'a str,
    /// Scales of the axes.
    pub axes: Axes,
    /// What is drawn.
    pub series: Vec<Series>,
    /// Events.
    pub marks: Vec<Mark>,
}

impl Plot<'_> {
    /// Writes the plot as SVG.
    pub fn write(&self, path: &Path) -> Result<()> {
        let mut x = Span::default();
        let mut y = Span::default();
        for point in self.series.iter().flat_map(|series| &series.points).filter(|point| self.shows(point)) {
            x.include(point.0);
            y.include(point.1);
        }
        for bar in
            self.series.iter().flat_map(|series| &series.bars).filter(|bar| bar.0.is_finite() && bar.1.is_finite())
        {
            y.include(bar.0);
            y.include(bar.1);
        }
        let root = SVGBackend::new(path, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(text)?;
        let (area, legend) = root.split_horizontally(SIZE.0 - self.legend_width());
        self.draw_legend(&legend)?;
        let mut builder = ChartBuilder::on(&area);
        builder.caption(self.title, (FONT, 21)).margin(14).margin_right(22).x_label_area_size(46).y_label_area_size(72);
        match self.axes {
            Axes::Logarithmic => {
                let (x, y) = (x.widened_by_factor(1.4), y.widened_by_factor(2.0));
                let bottom_top = (y.start, y.end);
                let mut chart = builder.build_cartesian_2d(x.log_scale(), y.log_scale()).map_err(text)?;
                self.draw(&mut chart, bottom_top, &power)?;
            }
            Axes::FromZero => {
                y.include(0.0);
                let y = y.widened_above(0.06);
                let marked = self
                    .series
                    .iter()
                    .any(|series| matches!(series.style, Style::Marked | Style::Points | Style::Dots));
                let x = x.widened_by_part(if marked { 0.03 } else { 0.0 });
                let bottom_top = (y.start, y.end);
                let mut chart = builder.build_cartesian_2d(x, y).map_err(text)?;
                self.draw(&mut chart, bottom_top, &decimal)?;
            }
        }
        root.present().map_err(text)
    }

    fn shows(&self, point: &(f64, f64)) -> bool {
        point.0.is_finite()
            && point.1.is_finite()
            && !(self.axes == Axes::Logarithmic && (point.0 <= 0.0 || point.1 <= 0.0))
    }

    fn draw<'a, X, Y>(
        &self,
        chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
        bottom_top: (f64, f64),
        tick: &dyn Fn(&f64) -> String,
    ) -> Result<()>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style((FONT, 17))
            .label_style((FONT, 14))
            .x_label_formatter(tick)
            .y_label_formatter(tick)
            .max_light_lines(if self.axes == Axes::Logarithmic { 10 } else { 1 })
            .bold_line_style(RGBColor(220, 220, 220))
            .light_line_style(RGBColor(243, 243, 243))
            .draw()
            .map_err(text)?;
        for mark in &self.marks {
            let line = [(mark.at, bottom_top.0), (mark.at, bottom_top.1)];
            chart.draw_series(DashedLineSeries::new(line, 4, 4, GREY.stroke_width(1))).map_err(text)?;
            // The name stands left of the line, where the plot has room.
            let style = (FONT, 13).into_font().color(&RGBColor(90, 90, 90)).pos(Pos::new(HPos::Right, VPos::Top));
            let name = EmptyElement::at(line[1]) + Text::new(mark.name.clone(), (-5, 5), style);
            chart.draw_series(std::iter::once(name)).map_err(text)?;
        }
        for (index, series) in self.series.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let points: Vec<(f64, f64)> = series.points.iter().copied().filter(|point| self.shows(point)).collect();
            let line = colour.stroke_width(2);
            let bars = series.points.iter().zip(&series.bars).filter(|(_, bar)| bar.0.is_finite() && bar.1.is_finite());
            let bars = bars.map(|(&(x, y), &(low, high))| {
                ErrorBar::new_vertical(x, low.max(bottom_top.0), y, high.min(bottom_top.1), colour.stroke_width(1), 8)
            });
            chart.draw_series(bars).map_err(text)?;
            if series.style == Style::Dashed {
                chart.draw_series(DashedLineSeries::new(points, 7, 5, line)).map_err(text)?;
                continue;
            }
            if series.style == Style::Dots {
                let dots = points.iter().map(|&point| Circle::new(point, 1, colour.mix(0.5).filled()));
                chart.draw_series(dots).map_err(text)?;
                continue;
            }
            if series.style != Style::Line {
                let marks = points.iter().map(|&point| Circle::new(point, 4, colour.filled()));
                chart.draw_series(marks).map_err(text)?;
            }
            if series.style != Style::Points {
                chart.draw_series(LineSeries::new(points, line)).map_err(text)?;
            }
        }
        Ok(())
    }

    /// Room for the longest name, pixels; nothing for a single series.
    fn legend_width(&self) -> u32 {
        let longest = self.series.iter().map(|series| series.name.chars().count()).max().unwrap_or(0);
        if self.series.len() > 1 { 50 + 8 * longest as u32 } else { 0 }
    }

    /// Names beside the plot, where they hide nothing.
    fn draw_legend(&self, area: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<()> {
        if self.series.len() < 2 {
            return Ok(());
        }
        for (index, series) in self.series.iter().enumerate() {
            let line = COLOURS[index % COLOURS.len()].stroke_width(2);
            let y = 62 + 24 * index as i32;
            let ends = vec![(0, y), (28, y)];
            match series.style {
                Style::Dashed => {
                    for x in [0, 11, 22] {
                        area.draw(&PathElement::new(vec![(x, y), (x + 7, y)], line)).map_err(text)?;
                    }
                }
                Style::Line => area.draw(&PathElement::new(ends, line)).map_err(text)?,
                Style::Marked => {
                    area.draw(&PathElement::new(ends, line)).map_err(text)?;
                    area.draw(&Circle::new((14, y), 4, line.filled())).map_err(text)?;
                }
                Style::Points | Style::Dots => {
                    let size = if series.style == Style::Points { 4 } else { 2 };
                    area.draw(&Circle::new((14, y), size, line.filled())).map_err(text)?;
                }
            }
            let style = (FONT, 14).into_text_style(area).pos(Pos::new(HPos::Left, VPos::Center));
            area.draw(&Text::new(series.name.clone(), (36, y), style)).map_err(text)?;
        }
        Ok(())
    }
}

/// Least and greatest of some numbers.
#[derive(Default)]
struct Span(Option<(f64, f64)>);

impl Span {
    fn include(&mut self, value: f64) {
        let (low, high) = self.0.unwrap_or((value, value));
        self.0 = Some((low.min(value), high.max(value)));
    }

    fn widened_by_part(&self, part: f64) -> std::ops::Range<f64> {
        let (low, high) = self.0.unwrap_or((0.0, 1.0));
        let width = if high > low { high - low } else { high.abs().max(1.0) };
        low - part * width..high + part.max(if high > low { 0.0 } else { 1.0 }) * width
    }

    /// From 0, or the least value below it, to a little above the greatest.
    fn widened_above(&self, part: f64) -> std::ops::Range<f64> {
        let (low, high) = self.0.unwrap_or((0.0, 1.0));
        let high = if high > low { high } else { low + 1.0 };
        low..high + part * (high - low)
    }

    fn widened_by_factor(&self, factor: f64) -> std::ops::Range<f64> {
        let (low, high) = self.0.unwrap_or((1.0, 10.0));
        low / factor..high * factor
    }
}

/// A number as short as it can be read.
fn decimal(value: &f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_string() } else { text.to_string() }
}

/// A tick of a logarithmic axis: one figure, and only 1, 2, 3 and 5 are named.
fn power(value: &f64) -> String {
    let text = format!("{value:.0e}");
    // Within one decade the ticks would run into each other.
    if text.starts_with(['4', '6', '7', '8', '9']) {
        return String::new();
    }
    // Within a few powers of ten of 1 plain digits read better.
    text.parse::<f64>().ok().filter(|value| (1e-3..1e4).contains(value)).map_or(text, |value| value.to_string())
}

fn text<E: std::fmt::Display>(error: E) -> Box<dyn std::error::Error> {
    error.to_string().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_short() {
        assert_eq!([0.1 + 0.2, -0.0, 1500.0, 2.5].map(|x| decimal(&x)), ["0.3", "0", "1500", "2.5"]);
        assert_eq!([0.30000000000000004, 1e-9, 9.999999e-8, 20.0].map(|x| power(&x)), ["0.3", "1e-9", "1e-7", "20"]);
    }
}
