//! The frame of an HTML page with its style in it: a page is one file.

pub(crate) use crate::name::escaped;

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;color:#1b1f24;background:#fff;max-width:72rem;\
margin:2rem auto;padding:0 1rem}h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem}\
body>svg,figure>svg{max-width:100%;height:auto}figure{margin:0}.wide{overflow-x:auto}\
.panels{display:flex;flex-wrap:wrap;gap:.5rem}.panels>figure{flex:0 1 auto}\
table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums}\
th{text-align:left;border-bottom:2px solid #57606a;padding:.3rem .7rem;vertical-align:bottom}\
td{border-bottom:1px solid #d0d7de;padding:.2rem .7rem;white-space:nowrap}\
td.number,th.number{text-align:right}tr.beyond td{color:#6e7781}\
p.note{font-size:.85rem;color:#57606a;margin:.3rem 0}";

/// An HTML page; the title is plain text, the body is HTML.
pub(crate) fn document(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n",
        escaped(title)
    )
}

/// Whether the name of a file is that of a page.
pub(crate) fn is_page(file: &std::path::Path) -> bool {
    file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html"))
}
