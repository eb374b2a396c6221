//! The report: one HTML file with everything inside.

use crate::Result;
use base64::Engine;
use std::fmt::Write;
use std::path::Path;

/// A picture with its caption, or a sentence in its place.
pub struct Figure {
    /// Markup of the picture; empty for a mere sentence.
    picture: String,
    caption: String,
}

impl Figure {
    /// An SVG file of the output folder.
    pub fn svg(out: &Path, file: &str, caption: String) -> Result<Figure> {
        let text = std::fs::read_to_string(out.join(file)).map_err(|error| format!("{file}: {error}"))?;
        Ok(Figure { picture: text, caption })
    }

    /// A PNG image.
    pub fn png(bytes: &[u8], caption: String) -> Figure {
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        let picture = format!("<img alt=\"\" src=\"data:image/png;base64,{data}\">");
        Figure { picture, caption }
    }

    /// A panel of the paper that is an experiment.
    pub fn no_data(sentence: &str) -> Figure {
        Figure { picture: String::new(), caption: sentence.to_string() }
    }
}

/// Text as HTML.
pub fn escape(text: &str) -> String {
    // A number stays with its per cent sign.
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace(" %", "\u{a0}%").replace('\n', "<br>")
}

/// The page under construction.
pub struct Page {
    body: String,
}

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; color: #1d2733; max-width: 1160px; margin: 2rem auto; padding: 0 1.2rem; }
h1 { font-size: 1.7rem; line-height: 1.25; } h2 { font-size: 1.3rem; margin-top: 2.6rem; border-bottom: 1px solid #d5dbe2; }
h3 { font-size: 1.08rem; margin-top: 1.6rem; }
p, figcaption, li { max-width: 62rem; }
figure { margin: 1.2rem 0; } figure svg { max-width: 100%; height: auto; display: block; }
figcaption { color: #46505c; font-size: 0.93rem; }
.panels { display: flex; flex-wrap: wrap; gap: 0.4rem 1rem; align-items: flex-end; }
.panels figure { margin: 0.3rem 0; width: 350px; } .panels img { width: 100%; display: block; border: 1px solid #e3e7eb; }
.nodata { border-left: 4px solid #c3cbd4; padding: 0.3rem 0.8rem; color: #46505c; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.87rem; margin: 0.8rem 0; }
th, td { text-align: right; padding: 0.25rem 0.6rem; border-bottom: 1px solid #e3e7eb; vertical-align: top; }
th { background: #f3f5f8; font-weight: 600; } td:first-child, th:first-child, td.text, th.text { text-align: left; }
td.lines { min-width: 21rem; }
td.agrees { background: #e2f4ea; } td.doesnot { background: #fde5dc; } td.cannotbetold { background: #fdf4d3; }
";

impl Page {
    /// An empty page with a heading.
    pub fn new(title: &str) -> Page {
        Page { body: format!("<h1>{}</h1>\n", escape(title)) }
    }

    /// A heading of a section.
    pub fn section(&mut self, title: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(title));
    }

    /// A heading within a section.
    pub fn heading(&mut self, title: &str) {
        let _ = writeln!(self.body, "<h3>{}</h3>", escape(title));
    }

    /// A paragraph.
    pub fn text(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    /// A figure across the page.
    pub fn figure(&mut self, figure: &Figure) {
        let caption = escape(&figure.caption);
        let _ = if figure.picture.is_empty() {
            writeln!(self.body, "<p class=\"nodata\">{caption}</p>")
        } else {
            writeln!(self.body, "<figure>{}<figcaption>{caption}</figcaption></figure>", figure.picture)
        };
    }

    /// Small figures side by side.
    pub fn panels(&mut self, figures: &[Figure]) {
        self.body.push_str("<div class=\"panels\">");
        figures.iter().for_each(|figure| self.figure(figure));
        self.body.push_str("</div>\n");
    }

    /// A table. `text`: columns besides the first that hold words.
    pub fn table(&mut self, heading: &[&str], text: &[usize], rows: &[Vec<String>]) {
        let class = |k: usize| if text.contains(&k) { " class=\"text\"" } else { "" };
        let cells: String =
            heading.iter().enumerate().map(|(k, cell)| format!("<th{}>{}</th>", class(k), escape(cell))).collect();
        let _ = writeln!(self.body, "<div class=\"scroll\"><table><tr>{cells}</tr>");
        for row in rows {
            let cells: String = row
                .iter()
                .enumerate()
                .map(|(k, cell)| {
                    let class = match cell.as_str() {
                        "agrees" | "does not" | "cannot be told" => {
                            format!(" class=\"text {}\"", cell.replace(' ', ""))
                        }
                        // Lists need room, so that their lines do not break.
                        list if list.contains('\n') => " class=\"text lines\"".to_string(),
                        _ => class(k).to_string(),
                    };
                    format!("<td{class}>{}</td>", escape(cell))
                })
                .collect();
            let _ = writeln!(self.body, "<tr>{cells}</tr>");
        }
        self.body.push_str("</table></div>\n");
    }

    /// Writes the page.
    pub fn write(&self, path: &Path, title: &str) -> Result<()> {
        let page = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">\
             <title>{}</title><style>{STYLE}</style></head><body>\n{}</body></html>\n",
            escape(title),
            self.body
        );
        std::fs::write(path, page).map_err(|error| format!("{}: {error}", path.display()).into())
    }
}
