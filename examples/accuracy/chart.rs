//! A chart on logarithmic axes.

use crate::svg::{Anchor, Marker, Stroke, Svg};

/// What is drawn.
pub(crate) struct Chart {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) series: Vec<Series>,
    /// Drawn thick behind the series: points that no other beats.
    pub(crate) front: Vec<(f64, f64)>,
    /// Thin lines of a slope, through the middle of the series.
    pub(crate) guides: Vec<Guide>,
    /// Errors below are those of the reference.
    pub(crate) floor: Option<f64>,
}

/// A logarithmic axis.
pub(crate) struct Axis {
    pub(crate) label: String,
    pub(crate) format: fn(f64) -> String,
    /// Where ticks stand and what they say; chosen by themselves if there are none.
    pub(crate) ticks: Vec<(f64, String)>,
}

pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) color: &'static str,
    pub(crate) marker: Marker,
    pub(crate) points: Vec<Dot>,
}

/// A point of a series.
pub(crate) struct Dot {
    pub(crate) at: (f64, f64),
    /// The value of the knob, if it is to be read.
    pub(crate) label: String,
}

pub(crate) struct Guide {
    pub(crate) slope: f64,
    pub(crate) name: &'static str,
    pub(crate) dashes: &'static str,
}

impl Guide {
    fn stroke(&self) -> Stroke<'_> {
        Stroke {
            color: "#666666",
            width: 1.3,
            dashes: self.dashes,
        }
    }
}

/// Colours that most people tell apart (Okabe and Ito 2008), each with a marker.
pub(crate) const STYLES: [(&str, Marker); 7] = [
    ("#0072B2", Marker::Circle),
    ("#D55E00", Marker::Square),
    ("#009E73", Marker::Triangle),
    ("#AA4499", Marker::Diamond),
    ("#000000", Marker::Cross),
    ("#56B4E9", Marker::Wedge),
    ("#8A6D00", Marker::Plus),
];

const SIZE: [f64; 2] = [1000.0, 580.0];
/// Left, top, right and bottom edge of the plot.
const PLOT: [f64; 4] = [92.0, 74.0, 730.0, 512.0];
const INK: &str = "#222222";
const GRID: &str = "#dddddd";
const FRONT: Stroke = Stroke {
    color: "#ffd24d",
    width: 11.0,
    dashes: "",
};
const FLOOR: &str = "#eeeeee";
const TEXT: f64 = 14.0;

/// Where values lie on the page.
struct Scale {
    x: [f64; 2],
    y: [f64; 2],
}

impl Scale {
    /// Room for all points, and the floor, with some air around.
    fn of(chart: &Chart) -> Self {
        let dots = || chart.series.iter().flat_map(|s| &s.points);
        let range = |values: Vec<f64>, air: f64| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(0.0, f64::max);
            let (low, high) = if low <= high { (low, high) } else { (0.1, 1.0) };
            let air = (high / low).powf(air).max(1.3);
            [(low / air).ln(), (high * air).ln()]
        };
        let ticks = |axis: &Axis| axis.ticks.iter().map(|t| t.0).collect::<Vec<_>>();
        let x = dots().map(|d| d.at.0).chain(ticks(&chart.x)).collect();
        let y = dots()
            .map(|d| d.at.1.max(chart.floor.unwrap_or(0.0)))
            .chain(chart.floor)
            .chain(ticks(&chart.y))
            .collect();
        Self {
            x: range(x, 0.05),
            y: range(y, 0.08),
        }
    }

    fn x(&self, value: f64) -> f64 {
        let [left, _, right, _] = PLOT;
        left + (value.ln() - self.x[0]) / (self.x[1] - self.x[0]) * (right - left)
    }

    fn y(&self, value: f64) -> f64 {
        let [_, top, _, bottom] = PLOT;
        bottom - (value.ln() - self.y[0]) / (self.y[1] - self.y[0]) * (bottom - top)
    }

    fn at(&self, (x, y): (f64, f64)) -> [f64; 2] {
        [self.x(x), self.y(y)]
    }
}

impl Chart {
    pub(crate) fn draw(&self) -> String {
        let mut svg = Svg::new(SIZE[0], SIZE[1]);
        let scale = Scale::of(self);
        let [left, top, ..] = PLOT;
        svg.text([left, 30.0], 20.0, Anchor::Start, INK, &self.title);
        svg.text([left, 54.0], TEXT, Anchor::Start, INK, &self.subtitle);
        debug_assert!(top > 54.0, "the plot begins below the titles");
        self.draw_floor(&mut svg, &scale);
        self.draw_axes(&mut svg, &scale);
        self.draw_guides(&mut svg, &scale);
        let front: Vec<[f64; 2]> = self.front.iter().map(|&p| scale.at(p)).collect();
        svg.line(&front, FRONT);
        let mut taken = Taken::default();
        for series in &self.series {
            self.draw_series(&mut svg, &scale, series, &mut taken);
        }
        self.label_series(&mut svg, &scale, &mut taken);
        self.draw_legend(&mut svg);
        svg.finish()
    }

    fn draw_floor(&self, svg: &mut Svg, scale: &Scale) {
        let Some(floor) = self.floor else { return };
        let ([left, _, right, bottom], y) = (PLOT, scale.y(floor));
        svg.rect([left, y, right - left, bottom - y], FLOOR, 1.0);
        let edge = Stroke {
            color: INK,
            width: 1.0,
            dashes: "",
        };
        svg.line(&[[left, y], [right, y]], edge);
    }

    fn draw_axes(&self, svg: &mut Svg, scale: &Scale) {
        let [left, top, right, bottom] = PLOT;
        let grid = Stroke {
            color: GRID,
            width: 1.0,
            dashes: "",
        };
        for (value, text) in self.x.ticks(scale.x) {
            let x = scale.x(value);
            svg.line(&[[x, top], [x, bottom]], grid);
            svg.text([x, bottom + 20.0], TEXT, Anchor::Middle, INK, &text);
        }
        for (value, text) in self.y.ticks(scale.y) {
            let y = scale.y(value);
            svg.line(&[[left, y], [right, y]], grid);
            svg.text([left - 8.0, y + 5.0], TEXT, Anchor::End, INK, &text);
        }
        let frame = Stroke { color: INK, ..grid };
        svg.line(&[[left, top], [left, bottom], [right, bottom]], frame);
        let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
        svg.text(
            [middle[0], bottom + 48.0],
            15.0,
            Anchor::Middle,
            INK,
            &self.x.label,
        );
        svg.turned_text(
            [24.0, middle[1]],
            15.0,
            Anchor::Middle,
            INK,
            &self.y.label,
            -90.0,
        );
    }

    /// Guides start at the upper left, one a little below the other.
    fn draw_guides(&self, svg: &mut Svg, scale: &Scale) {
        let ([x0, x1], [y0, y1]) = (scale.x, scale.y);
        for (i, guide) in self.guides.iter().enumerate() {
            let start = y0 + (y1 - y0) * (0.97 - 0.06 * i as f64);
            // Until it leaves on the right or below.
            let length = (x1 - x0).min((y0 - start) / guide.slope);
            let end = (x0 + length, start + guide.slope * length);
            let points = [(x0, start), end].map(|(x, y)| scale.at((x.exp(), y.exp())));
            svg.line(&points, guide.stroke());
        }
    }

    fn draw_series(&self, svg: &mut Svg, scale: &Scale, series: &Series, taken: &mut Taken) {
        let shown = |dot: &Dot| scale.at((dot.at.0, dot.at.1.max(self.floor.unwrap_or(0.0))));
        let points: Vec<[f64; 2]> = series.points.iter().map(shown).collect();
        let line = Stroke {
            color: series.color,
            width: 2.0,
            dashes: "",
        };
        svg.line(&points, line);
        taken.take_line(&points);
        for (dot, &point) in series.points.iter().zip(&points) {
            let told = self.floor.is_none_or(|floor| dot.at.1 >= floor);
            svg.marker(series.marker, point, series.color, told);
            taken.take([point[0] - 7.0, point[1] - 7.0, 14.0, 14.0]);
        }
    }

    /// Writes values of knobs where they cover nothing.
    fn label_series(&self, svg: &mut Svg, scale: &Scale, taken: &mut Taken) {
        for series in &self.series {
            for dot in series.points.iter().filter(|d| !d.label.is_empty()) {
                let [x, y] = scale.at((dot.at.0, dot.at.1.max(self.floor.unwrap_or(0.0))));
                let width = 7.2 * dot.label.chars().count() as f64;
                let spots = [
                    [8.0, -18.0],
                    [-8.0 - width, 6.0],
                    [8.0, 6.0],
                    [-8.0 - width, -18.0],
                ];
                let boxes = spots.map(|[dx, dy]| [x + dx, y + dy, width, 13.0]);
                if let Some(free) = boxes.into_iter().find(|b| taken.is_free(*b)) {
                    taken.take(free);
                    let at = [free[0], free[1] + 11.0];
                    svg.text(at, 12.0, Anchor::Start, series.color, &dot.label);
                }
            }
        }
    }

    fn draw_legend(&self, svg: &mut Svg) {
        let [_, top, right, _] = PLOT;
        let (x, mut y) = (right + 18.0, top + 10.0);
        for series in &self.series {
            let line = Stroke {
                color: series.color,
                width: 2.0,
                dashes: "",
            };
            svg.line(&[[x, y], [x + 30.0, y]], line);
            svg.marker(series.marker, [x + 15.0, y], series.color, true);
            svg.text([x + 40.0, y + 5.0], TEXT, Anchor::Start, INK, &series.name);
            y += 26.0;
        }
        y += 8.0;
        if !self.front.is_empty() {
            svg.line(&[[x + 4.0, y], [x + 26.0, y]], FRONT);
            svg.text(
                [x + 40.0, y + 5.0],
                TEXT,
                Anchor::Start,
                INK,
                "Pareto front",
            );
            y += 26.0;
        }
        for guide in &self.guides {
            svg.line(&[[x, y], [x + 30.0, y]], guide.stroke());
            svg.text([x + 40.0, y + 5.0], TEXT, Anchor::Start, INK, guide.name);
            y += 26.0;
        }
        if self.floor.is_some() {
            svg.rect([x, y - 8.0, 30.0, 16.0], FLOOR, 1.0);
            svg.text(
                [x + 40.0, y + 5.0],
                TEXT,
                Anchor::Start,
                INK,
                "reference not better",
            );
            svg.text(
                [x + 40.0, y + 23.0],
                TEXT,
                Anchor::Start,
                INK,
                "(points hollow)",
            );
        }
    }
}

/// What of the plot is covered.
#[derive(Default)]
struct Taken(Vec<[f64; 4]>);

impl Taken {
    fn take(&mut self, area: [f64; 4]) {
        self.0.push(area);
    }

    fn take_line(&mut self, points: &[[f64; 2]]) {
        const STEP: f64 = 4.0;
        for ends in points.windows(2) {
            let [dx, dy] = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
            let steps = (dx.hypot(dy) / STEP).ceil();
            for i in 0..steps as u32 {
                let part = f64::from(i) / steps;
                self.take([ends[0][0] + dx * part, ends[0][1] + dy * part, 1.0, 1.0]);
            }
        }
    }

    fn is_free(&self, [x, y, w, h]: [f64; 4]) -> bool {
        let [left, top, right, bottom] = PLOT;
        let inside = x >= left && y >= top && x + w <= right && y + h <= bottom;
        let clear = |&[x2, y2, w2, h2]: &[f64; 4]| {
            x + w <= x2 || x2 + w2 <= x || y + h <= y2 || y2 + h2 <= y
        };
        inside && self.0.iter().all(clear)
    }
}

impl Axis {
    /// Powers of ten; between them 2 and 5 where there is room.
    fn ticks(&self, [low, high]: [f64; 2]) -> Vec<(f64, String)> {
        if !self.ticks.is_empty() {
            return self.ticks.clone();
        }
        let decades = (high - low) / 10_f64.ln();
        let steps: &[f64] = match decades {
            d if d < 2.5 => &[1.0, 2.0, 5.0],
            d if d < 4.0 => &[1.0, 3.0],
            _ => &[1.0],
        };
        let powers = (low / 10_f64.ln()).floor() as i32..=(high / 10_f64.ln()).ceil() as i32;
        let values = powers.flat_map(|p| steps.iter().map(move |s| s * 10_f64.powi(p)));
        let within = values.filter(|v| (low..=high).contains(&v.ln()));
        within.map(|v| (v, (self.format)(v))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis() -> Axis {
        Axis {
            label: "x".into(),
            format: |v| format!("{v}"),
            ticks: Vec::new(),
        }
    }

    #[test]
    fn ticks_lie_within() {
        let ticks = axis().ticks([0.9_f64.ln(), 60_f64.ln()]);
        let texts: Vec<&str> = ticks.iter().map(|t| t.1.as_str()).collect();
        assert_eq!(texts, ["1", "2", "5", "10", "20", "50"]);
    }

    #[test]
    fn labels_do_not_cover_each_other() {
        let mut taken = Taken::default();
        assert!(taken.is_free([100.0, 100.0, 50.0, 13.0]));
        taken.take([100.0, 100.0, 50.0, 13.0]);
        assert!(!taken.is_free([140.0, 90.0, 50.0, 13.0]));
        assert!(taken.is_free([151.0, 100.0, 50.0, 13.0]));
        assert!(
            !taken.is_free([10.0, 100.0, 50.0, 13.0]),
            "outside the plot"
        );
    }

    #[test]
    fn points_below_the_floor_are_hollow_and_on_it() {
        let dot = |y| Dot {
            at: (1.0, y),
            label: "64".into(),
        };
        let chart = Chart {
            title: "a < b".into(),
            subtitle: String::new(),
            x: axis(),
            y: axis(),
            series: vec![Series {
                name: "method".into(),
                color: "#123456",
                marker: Marker::Square,
                points: vec![dot(1.0), dot(1e-9)],
            }],
            front: Vec::new(),
            guides: Vec::new(),
            floor: Some(0.1),
        };
        let drawn = chart.draw();
        let filled = |fill: &str| {
            drawn
                .matches(&format!("fill=\"{fill}\" stroke=\"#123456\""))
                .count()
        };
        assert_eq!(
            (filled("#123456"), filled("white")),
            (2, 1),
            "one of them in the legend"
        );
        assert!(drawn.contains("a &lt; b") && !drawn.contains("NaN"));
    }
}
