//! A sketch as SVG; colors come from a style sheet, so that the reader's light or dark setting decides.

use super::sketch::{Anchor, Role, Shape, Sketch};
use base64::Engine as _;
use std::fmt::Write as _;

/// Text that may stand between tags and inside quotes, in HTML and in SVG; control characters, which XML forbids, are
/// shown as the replacement sign.
pub fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' | '\t' => safe.push(letter),
            control if control.is_control() => safe.push('\u{fffd}'),
            other => safe.push(other),
        }
    }
    safe
}

/// Rules that hold for every picture, besides those made from the roles.
pub const SVG_STYLE: &str = "svg text{font-family:system-ui,sans-serif;stroke:none}\
svg .map-image{image-rendering:pixelated}";

/// The style sheet of all roles; `dark` chooses the colors.
pub fn role_rules(dark: bool) -> String {
    let mut css = String::new();
    let choose = |light: u32, night: u32| if dark { night } else { light };
    for role in Role::ALL {
        let style = role.style();
        let _ = write!(css, ".{}{{", style.class);
        match style.stroke {
            Some((light, night)) => {
                let _ = write!(css, "stroke:#{:06x};stroke-width:{};", choose(light, night), style.width);
            }
            None => css.push_str("stroke:none;"),
        }
        if let Some((dash, gap)) = style.dash {
            let _ = write!(css, "stroke-dasharray:{dash} {gap};");
        }
        match style.fill {
            Some((light, night, opacity)) => {
                let _ = write!(css, "fill:#{:06x};fill-opacity:{opacity}", choose(light, night));
            }
            None => css.push_str("fill:none"),
        }
        css.push_str("}\n");
    }
    css
}

/// The sketch as an `<svg>` element. `label` says what it shows to those who cannot see it.
pub fn svg(sketch: &Sketch, label: &str) -> String {
    let (width, height, label) = (sketch.width, sketch.height, escape(label));
    let mut out =
        format!("<svg viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" aria-label=\"{label}\">\n");
    for shape in &sketch.shapes {
        write_shape(&mut out, shape);
    }
    out.push_str("</svg>\n");
    out
}

/// Writing into a string cannot fail.
fn write_shape(out: &mut String, shape: &Shape) {
    match shape {
        Shape::Image { image, matrix } => {
            let png = image.png().map(|png| base64::engine::general_purpose::STANDARD.encode(png));
            let numbers: Vec<String> = matrix.iter().map(|v| format!("{v:.6}")).collect();
            let _ = writeln!(
                out,
                "<image class=\"map-image\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" \
                 transform=\"matrix({})\" href=\"data:image/png;base64,{}\"/>",
                image.width,
                image.height,
                numbers.join(" "),
                png.unwrap_or_default()
            );
        }
        Shape::Chain { role, points, closed } => {
            let class = role.style().class;
            let mut path = String::with_capacity(points.len() * 12);
            for (idx, [x, y]) in points.iter().enumerate() {
                let _ = write!(path, "{}{x:.1} {y:.1}", if idx == 0 { "M" } else { "L" });
            }
            let end = if *closed { "Z" } else { "" };
            let _ = writeln!(out, "<path class=\"{class}\" d=\"{path}{end}\"/>");
        }
        Shape::Circle { role, center: [x, y], radius } => {
            let class = role.style().class;
            let _ =
                writeln!(out, "<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"/>");
        }
        Shape::Text { role, at: [x, y], size, anchor, bold, text } => {
            let class = role.style().class;
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            let weight = if *bold { " font-weight=\"bold\"" } else { "" };
            let _ = writeln!(
                out,
                "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" \
                 text-anchor=\"{anchor}\"{weight}>{}</text>",
                escape(text)
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_can_leave_its_place() {
        let mut sketch = Sketch::sheet(10.0, 10.0);
        sketch.text(Role::Text, [0.0, 0.0], 3.0, Anchor::Start, "</text><script>alert('1')</script>\u{1}");
        let svg = svg(&sketch, "\"><b>");
        assert!(!svg.contains("<script") && !svg.contains("<b>") && !svg.contains('\u{1}'), "{svg}");
        assert!(svg.contains("&lt;script&gt;alert(&#39;1&#39;)"));
    }

    #[test]
    fn every_role_has_rules_on_both_papers() {
        for role in Role::ALL {
            let rule = format!(".{}{{", role.style().class);
            assert!(role_rules(false).contains(&rule) && role_rules(true).contains(&rule), "{rule}");
        }
        assert_ne!(role_rules(false), role_rules(true));
    }
}
