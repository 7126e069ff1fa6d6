//! The few shapes of SVG that charts are drawn with.

use std::fmt::Write;

pub(crate) struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// Where text stands from its point.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(crate) struct Stroke<'a> {
    pub(crate) color: &'a str,
    pub(crate) width: f64,
    /// Lengths of dashes and gaps; empty for a whole line.
    pub(crate) dashes: &'a str,
}

/// Shapes that can be told apart without colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    Cross,
    Plus,
    Wedge,
}

impl Svg {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let mut svg = Self {
            width,
            height,
            body: String::new(),
        };
        svg.rect([0.0, 0.0, width, height], "white", 1.0);
        svg
    }

    fn add(&mut self, shape: std::fmt::Arguments) {
        // Writing to a string does not fail.
        let _ = writeln!(self.body, "{shape}");
    }

    pub(crate) fn rect(&mut self, [x, y, width, height]: [f64; 4], fill: &str, opacity: f64) {
        self.add(format_args!(
            r#"<rect x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}" fill="{fill}" fill-opacity="{opacity}"/>"#
        ));
    }

    pub(crate) fn line(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        let points: Vec<String> = points
            .iter()
            .map(|[x, y]| format!("{x:.1},{y:.1}"))
            .collect();
        let Stroke {
            color,
            width,
            dashes,
        } = stroke;
        self.add(format_args!(
            r#"<polyline points="{}" fill="none" stroke="{color}" stroke-width="{width}" stroke-dasharray="{dashes}" stroke-linejoin="round" stroke-linecap="round"/>"#,
            points.join(" ")
        ));
    }

    pub(crate) fn text(
        &mut self,
        [x, y]: [f64; 2],
        size: f64,
        anchor: Anchor,
        color: &str,
        text: &str,
    ) {
        self.turned_text([x, y], size, anchor, color, text, 0.0);
    }

    /// Text turned by so many degrees about its point.
    pub(crate) fn turned_text(
        &mut self,
        [x, y]: [f64; 2],
        size: f64,
        anchor: Anchor,
        color: &str,
        text: &str,
        degrees: f64,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.add(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}" fill="{color}" transform="rotate({degrees} {x:.1} {y:.1})">{text}</text>"#
        ));
    }

    /// A marker, filled or with white inside.
    pub(crate) fn marker(&mut self, marker: Marker, [x, y]: [f64; 2], color: &str, filled: bool) {
        const R: f64 = 5.0;
        let at = |dx: f64, dy: f64| format!("{:.1} {:.1}", x + R * dx, y + R * dy);
        let path = |corners: &[(f64, f64)]| {
            let corners: Vec<String> = corners.iter().map(|&(dx, dy)| at(dx, dy)).collect();
            format!("M{}Z", corners.join("L"))
        };
        let shape = match marker {
            Marker::Circle => format!(
                "M{}A{R} {R} 0 1 0 {}A{R} {R} 0 1 0 {}Z",
                at(-1.0, 0.0),
                at(1.0, 0.0),
                at(-1.0, 0.0)
            ),
            Marker::Square => path(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
            Marker::Triangle => path(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]),
            Marker::Wedge => path(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]),
            Marker::Diamond => path(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]),
            Marker::Cross => format!(
                "M{}L{}M{}L{}",
                at(-0.9, -0.9),
                at(0.9, 0.9),
                at(-0.9, 0.9),
                at(0.9, -0.9)
            ),
            Marker::Plus => format!(
                "M{}L{}M{}L{}",
                at(-1.2, 0.0),
                at(1.2, 0.0),
                at(0.0, -1.2),
                at(0.0, 1.2)
            ),
        };
        let fill = if filled { color } else { "white" };
        self.add(format_args!(
            r#"<path d="{shape}" fill="{fill}" stroke="{color}" stroke-width="2"/>"#
        ));
    }

    pub(crate) fn finish(&self) -> String {
        let Self {
            width,
            height,
            body,
        } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-family=\"Helvetica, Arial, DejaVu Sans, sans-serif\">\n{body}</svg>\n"
        )
    }
}
