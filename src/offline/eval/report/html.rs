//! The report as one HTML page beside its pictures.

use crate::offline::eval::report::Report;
use crate::offline::eval::report::table::Table;

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2rem auto;max-width:1300px;padding:0 1rem;color:#222}\
table{border-collapse:collapse;margin:.6rem 0 1.6rem;font-variant-numeric:tabular-nums;font-size:13px}\
th,td{padding:.25rem .6rem;text-align:right;border-bottom:1px solid #ddd;white-space:nowrap}\
th:nth-child(-n+2),td:nth-child(-n+2){text-align:left}th{background:#f4f4f4}tr.drm td{background:#eef6ee;font-weight:600}\
tr.first td{border-top:2px solid #999}p.note{color:#666;margin:.2rem 0}img{width:100%;display:block;background:#111}\
figure{margin:0 0 1.6rem}figcaption{color:#444;margin:.3rem 0}.scroll{overflow-x:auto}";

/// Text with what HTML reserves replaced.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn cells(tag: &str, row: &[String]) -> String {
    row.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(&cell.replace("+-", "\u{b1}")))).collect()
}

impl Table {
    /// As an HTML section.
    pub fn html(&self) -> String {
        let mut before = None;
        let mut body = String::new();
        for row in &self.rows {
            let first = if before == row.first() { "" } else { " first" };
            let drm = row.get(1).filter(|key| key.ends_with("drm")).map_or("", |_| " drm");
            body += &format!("<tr class=\"{}\">{}</tr>\n", format!("{first}{drm}").trim(), cells("td", row));
            before = row.first();
        }
        format!(
            "<h2>{}</h2><p class=\"note\">{}</p><div class=\"scroll\"><table><tr>{}</tr>\n{body}</table></div>\n",
            escaped(&self.title),
            escaped(&self.note),
            cells("th", &self.head)
        )
    }
}

/// A page of tables and pictures (caption, file beside the page).
pub(crate) fn page(title: &str, lines: &[String], tables: &[Table], pictures: &[(String, String)]) -> String {
    let lines: String = lines.iter().map(|line| format!("<p>{}</p>\n", escaped(line))).collect();
    let tables: String = tables.iter().map(Table::html).collect();
    let figure = |(caption, file): &(String, String)| {
        let (caption, file) = (escaped(caption), escaped(file));
        format!(
            "<figure><figcaption>{caption}</figcaption><a href=\"{file}\"><img src=\"{file}\" alt=\"{caption}\" \
             loading=\"lazy\"></a></figure>\n"
        )
    };
    let pictures: String = pictures.iter().map(figure).collect();
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style></head>\n\
         <body><h1>{title}</h1>\n{lines}{tables}<h2>Pictures</h2>\n{pictures}</body></html>\n"
    )
}

impl Report {
    /// The page.
    pub fn html(&self) -> String {
        let count = |(name, level): (&String, &crate::offline::eval::report::LevelSummary)| {
            format!("{name}: {} scenes, {} frames scored", level.scenes, level.frames)
        };
        let lines: Vec<String> = self.levels.iter().map(count).collect();
        let pictures: Vec<(String, String)> =
            self.scenes.iter().filter_map(|(name, file)| Some((name.clone(), file.clone()?))).collect();
        page(&self.title, &lines, &self.tables(), &pictures)
    }
}
