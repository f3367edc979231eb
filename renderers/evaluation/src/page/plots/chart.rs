//! A chart as SVG: axes with round numbers, lines or bars, a legend. Black on white, as a paper has it.

use std::fmt::Write as _;

/// Size of a chart, and of the frame within it, in pixels.
const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 52.0;

/// How tall a line of the legend is.
const LINE: f64 = 18.0;

/// Colors that people with any kind of color vision tell apart (Okabe and Ito 2008), the darker ones first.
const COLORS: &[&str] = &["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"];

/// Forms of points, so that color is not all that tells series apart.
const DASHES: &[&str] = &["", "7 3", "2 3", "9 3 2 3"];

/// An axis.
pub(super) struct Axis {
    pub words: String,
    pub log: bool,
}

/// Points of one name.
pub(super) struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
}

/// How points are drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Lines,
    /// Bars from 0, each as wide as the points lie apart.
    Bars,
}

/// A chart.
pub(super) struct Chart {
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub series: Vec<Series>,
    pub mark: Mark,
    /// The slope of a straight line that is drawn beside the series, both axes being logarithmic.
    pub slope: Option<f64>,
    /// Ranges along x that are marked.
    pub bands: Vec<(f64, f64)>,
}

/// How many tiles have which ratio; none where there are no ratios.
pub(super) fn histogram(title: &str, ratios: &[f64], tolerance: Option<f64>) -> Option<Chart> {
    if ratios.is_empty() {
        return None;
    }
    // Symmetric around 1, wide enough for all but the farthest twentieth and for the tolerance.
    let mut off: Vec<f64> = ratios.iter().map(|ratio| (ratio - 1.0).abs()).collect();
    off.sort_by(f64::total_cmp);
    let most = off[(off.len() - 1) * 19 / 20].max(1.2 * tolerance.unwrap_or(0.0)).max(1e-6);
    let bins = 21_usize;
    let width = 2.0 * most / bins as f64;
    let mut counts = vec![0_usize; bins];
    for ratio in ratios {
        let at = ((ratio - 1.0 + most) / width).floor().clamp(0.0, bins as f64 - 1.0) as usize;
        counts[at] += 1;
    }
    let points = counts.iter().enumerate().map(|(at, count)| (1.0 - most + width * (at as f64 + 0.5), *count as f64));
    Some(Chart {
        title: title.to_owned(),
        x: Axis { words: "B / A (the outermost bars hold what lies beyond)".to_owned(), log: false },
        y: Axis { words: "tiles".to_owned(), log: false },
        series: vec![Series { name: "tiles".to_owned(), points: points.collect() }],
        mark: Mark::Bars,
        slope: None,
        bands: tolerance.map(|tolerance| (1.0 - tolerance, 1.0 + tolerance)).into_iter().collect(),
    })
}

/// From numbers to places.
struct Scale {
    log: bool,
    from: f64,
    to: f64,
    start: f64,
    end: f64,
}

impl Scale {
    fn new(log: bool, values: impl Iterator<Item = f64>, (start, end): (f64, f64), zero: bool) -> Self {
        let (mut from, mut to) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if zero {
            (from, to) = (0.0, to * 1.05);
        } else if log {
            let room = (to / from).powf(0.05).max(1.1);
            (from, to) = (from / room, to * room);
        } else {
            let room = (0.05 * (to - from)).max(1e-9 * to.abs()).max(1e-12);
            (from, to) = (from - room, to + room);
        }
        Self { log, from, to, start, end }
    }

    fn at(&self, value: f64) -> f64 {
        let share = if self.log {
            (value / self.from).ln() / (self.to / self.from).ln()
        } else {
            (value - self.from) / (self.to - self.from)
        };
        self.start + share * (self.end - self.start)
    }

    /// Round numbers along the axis.
    fn ticks(&self) -> Vec<f64> {
        let mut ticks = Vec::new();
        if self.log {
            let (low, high) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
            let decades = high - low;
            let steps: &[f64] = if decades <= 3 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            for power in low..=high {
                ticks.extend(steps.iter().map(|step| step * 10_f64.powi(power)));
            }
        } else {
            let rough = (self.to - self.from) / 6.0;
            let power = 10_f64.powf(rough.log10().floor());
            let step = [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|step| *step >= rough);
            let step = step.unwrap_or(rough);
            let first = (self.from / step).ceil();
            ticks.extend((0..20).map(|at| (first + f64::from(at)) * step));
        }
        ticks.retain(|tick| (self.from..=self.to).contains(tick));
        ticks
    }
}

/// A number as people write it.
fn number(value: f64) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e6).contains(&size) {
        return format!("{value:.0e}");
    }
    // Rounding of sums of steps is not to be seen.
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn plain(text: &str) -> String {
    let mut plain = String::new();
    for letter in text.chars() {
        match letter {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            letter if letter.is_control() => plain.push(' '),
            letter => plain.push(letter),
        }
    }
    plain
}

/// A text of at most `most` letters.
fn short(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

impl Chart {
    fn legend(&self) -> bool {
        self.mark == Mark::Lines
    }

    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let entries = self.series.len() + usize::from(self.slope.is_some());
        let below = if self.legend() { LINE * entries as f64 + 8.0 } else { 0.0 };
        let points = || self.series.iter().flat_map(|series| &series.points);
        let bars = self.mark == Mark::Bars;
        let edges = self.bands.iter().flat_map(|band| [band.0, band.1]);
        let x = Scale::new(self.x.log, points().map(|p| p.0).chain(edges), (LEFT, WIDTH - RIGHT), false);
        let y = Scale::new(self.y.log, points().map(|p| p.1), (HEIGHT - BOTTOM, TOP), bars);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {0}\" width=\"{WIDTH}\" height=\"{0}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<title>{1}</title>\n<rect width=\"{WIDTH}\" height=\"{0}\" fill=\"#fff\"/>\n\
             <text x=\"{LEFT}\" y=\"22\" font-size=\"14\" font-weight=\"600\">{2}</text>\n",
            HEIGHT + below,
            plain(&self.title),
            plain(&short(&self.title, 76))
        );
        for (from, to) in &self.bands {
            let _written = writeln!(
                svg,
                "<rect x=\"{:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#009e73\" fill-opacity=\"0.12\"/>",
                x.at(*from),
                x.at(*to) - x.at(*from),
                HEIGHT - BOTTOM - TOP
            );
        }
        self.axes(&mut svg, &x, &y);
        for (at, series) in self.series.iter().enumerate() {
            let (color, dash) = style(at);
            if bars {
                let half = series.points.windows(2).next().map_or(10.0, |two| 0.45 * (x.at(two[1].0) - x.at(two[0].0)));
                for point in &series.points {
                    let (middle, top) = (x.at(point.0), y.at(point.1));
                    let _written = writeln!(
                        svg,
                        "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{color}\"/>",
                        middle - half,
                        2.0 * half,
                        HEIGHT - BOTTOM - top
                    );
                }
                continue;
            }
            let places: Vec<String> =
                series.points.iter().map(|point| format!("{:.1},{:.1}", x.at(point.0), y.at(point.1))).collect();
            let _written = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"1.8\" stroke-dasharray=\"{dash}\"/>",
                places.join(" ")
            );
            for point in &series.points {
                let _written = writeln!(
                    svg,
                    "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{color}\"/>",
                    x.at(point.0),
                    y.at(point.1)
                );
            }
        }
        if let (Some(slope), Some(first)) = (self.slope, points().next()) {
            let far = x.to;
            let (start, end) = (first.1 * 0.7, first.1 * 0.7 * (far / first.0).powf(slope));
            // The line is cut at the frame.
            let end_x = if end < y.from { first.0 * (y.from / start).powf(1.0 / slope) } else { far };
            let end_y = start * (end_x / first.0).powf(slope);
            if start > y.from {
                let _written = writeln!(
                    svg,
                    "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"#777\" stroke-dasharray=\"3 4\"/>",
                    x.at(first.0),
                    y.at(start),
                    x.at(end_x),
                    y.at(end_y)
                );
            }
        }
        if self.legend() {
            self.names(&mut svg);
        }
        svg.push_str("</svg>\n");
        svg
    }

    fn axes(&self, svg: &mut String, x: &Scale, y: &Scale) {
        let foot = HEIGHT - BOTTOM;
        for tick in x.ticks() {
            let at = x.at(tick);
            let _written = writeln!(
                svg,
                "<line x1=\"{at:.1}\" y1=\"{TOP}\" x2=\"{at:.1}\" y2=\"{foot}\" stroke=\"#e4e4e4\"/><text x=\"{at:.1}\" y=\"{}\" \
                 text-anchor=\"middle\">{}</text>",
                foot + 16.0,
                number(tick)
            );
        }
        for tick in y.ticks() {
            let at = y.at(tick);
            let _written = writeln!(
                svg,
                "<line x1=\"{LEFT}\" y1=\"{at:.1}\" x2=\"{}\" y2=\"{at:.1}\" stroke=\"#e4e4e4\"/><text x=\"{}\" y=\"{:.1}\" \
                 text-anchor=\"end\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 6.0,
                at + 4.0,
                number(tick)
            );
        }
        let _written = writeln!(
            svg,
            "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#555\"/>\n<text x=\"{}\" y=\"{}\" \
             text-anchor=\"middle\">{}</text>\n<text transform=\"rotate(-90)\" x=\"{}\" y=\"16\" text-anchor=\"middle\">{}</text>",
            WIDTH - RIGHT - LEFT,
            foot - TOP,
            f64::midpoint(LEFT, WIDTH - RIGHT),
            foot + 38.0,
            plain(&self.x.words),
            -f64::midpoint(TOP, foot),
            plain(&short(&self.y.words, 60))
        );
    }

    fn names(&self, svg: &mut String) {
        let names = self.series.iter().enumerate().map(|(at, series)| (style(at), series.name.as_str()));
        let slope = self.slope.map(|_| (("#777", "3 4"), "slope -1/2: independent samples"));
        for (at, ((color, dash), name)) in names.chain(slope).enumerate() {
            let y = HEIGHT + LINE * (at as f64 + 0.5);
            let _written = writeln!(
                svg,
                "<line x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{}\" y2=\"{y:.1}\" stroke=\"{color}\" stroke-width=\"1.8\" \
                 stroke-dasharray=\"{dash}\"/><text x=\"{}\" y=\"{:.1}\">{}</text>",
                LEFT + 32.0,
                LEFT + 40.0,
                y + 4.0,
                plain(&short(name, 76))
            );
        }
    }

    /// The numbers (RFC 4180).
    pub(super) fn csv(&self) -> String {
        let field = |text: &str| match text.contains([',', '"', '\n', '\r']) {
            true => format!("\"{}\"", text.replace('"', "\"\"")),
            false => text.to_owned(),
        };
        let mut text = format!("series,{},{}\n", field(&self.x.words), field(&self.y.words));
        for series in &self.series {
            for (x, y) in &series.points {
                let _written = writeln!(text, "{},{x},{y}", field(&series.name));
            }
        }
        text
    }

    /// What is seen, in words.
    pub(super) fn words(&self) -> String {
        if self.mark == Mark::Bars {
            let count: f64 = self.series.iter().flat_map(|series| &series.points).map(|point| point.1).sum();
            return format!("histogram of {count} ratios");
        }
        let ends = self.series.iter().filter_map(|series| {
            let (first, last) = (series.points.first()?, series.points.last()?);
            let round = |value: f64| format!("{value:.3e}");
            Some(format!(
                "{}: {} at {} to {} at {}",
                series.name,
                round(first.1),
                number(first.0),
                round(last.1),
                number(last.0)
            ))
        });
        ends.collect::<Vec<_>>().join("; ")
    }
}

fn style(at: usize) -> (&'static str, &'static str) {
    (COLORS[at % COLORS.len()], DASHES[(at / COLORS.len()) % DASHES.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within() {
        let scale = Scale::new(true, [8.0, 64.0].into_iter(), (0.0, 100.0), false);
        assert_eq!(scale.ticks(), [10.0, 20.0, 50.0]);
        let scale = Scale::new(false, [0.95, 1.05].into_iter(), (0.0, 100.0), false);
        assert_eq!(scale.ticks().into_iter().map(number).collect::<Vec<_>>(), ["0.96", "0.98", "1", "1.02", "1.04"]);
        assert!((scale.at(1.0) - 50.0).abs() < 1e-9);
        assert_eq!([1e-6, 0.25, 20.0, -0.0].map(number), ["1e-6", "0.25", "20", "0"]);
    }

    #[test]
    fn histograms_count_every_ratio() {
        let ratios = [1.0, 1.01, 0.99, 5.0, 0.98];
        let chart = histogram("t", &ratios, Some(0.05)).expect("ratios");
        let count: f64 = chart.series[0].points.iter().map(|point| point.1).sum();
        assert_eq!((count, chart.series[0].points.len()), (5.0, 21));
        assert!(histogram("t", &[], None).is_none());
        assert!(histogram("t", &[1.0; 4], None).expect("equal").svg().contains("</svg>"));
    }
}
