"""HTML: text that is always escaped, tables, figures, and the page round them."""

import base64
import html
import io

from ..plot._style import style


class Markup(str):
    """Text that is HTML already; all other text is escaped where it is put in."""


def tag(name, *children, **attributes):
    """An element; children are text, `Markup`, or lists of both."""
    words = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(str(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    return Markup(f"<{name}{words}>{joined(children)}</{name}>")


def joined(children):
    """All of them, escaped unless they are `Markup`."""
    parts = []
    for child in children:
        if isinstance(child, Markup):
            parts.append(child)
        elif isinstance(child, (list, tuple)):
            parts.append(joined(child))
        elif child is not None:
            parts.append(html.escape(str(child)))
    return Markup("".join(parts))


def table(head, rows, *, numbers=()):
    """Rows under a head; columns in ``numbers`` are set flush right."""
    if not rows:
        return Markup("")
    kind = lambda k: "number" if k in numbers else None  # noqa: E731
    top = (
        tag("thead", tag("tr", [tag("th", h, class_=kind(k), scope="col") for k, h in enumerate(head)])) if head else ""
    )
    body = tag("tbody", [tag("tr", [tag("td", c, class_=kind(k)) for k, c in enumerate(row)]) for row in rows])
    return tag("div", tag("table", top, body), class_="wide")


def facts(pairs):
    """Names and what they are; pairs without a value are left out."""
    rows = [
        tag("tr", tag("th", name, scope="row"), tag("td", value))
        for name, value in pairs
        if value not in (None, "", [])
    ]
    return tag("div", tag("table", tag("tbody", rows), class_="facts"), class_="wide") if rows else Markup("")


def section(title, *children, note=None):
    """A section, unless there is nothing in it."""
    inside = joined(children)
    if not inside:
        return Markup("")
    return tag("section", tag("h2", title), tag("p", note, class_="note") if note else None, inside)


def picture(figure, caption, *, kind="png"):
    """A matplotlib figure within the page."""
    file = io.BytesIO()
    with style():
        figure.savefig(
            file, format=kind, dpi=140, metadata={"Date": None} if kind == "svg" else {"Software": "bsdfkit"}
        )
    data = base64.b64encode(file.getvalue()).decode()
    source = {"png": "image/png", "svg": "image/svg+xml"}[kind]
    width = round(96 * figure.get_figwidth())
    shown = tag("img", src=f"data:{source};base64,{data}", alt=caption)
    # An image is an empty element.
    shown = Markup(shown.removesuffix("</img>"))
    # A caption is no wider than its picture, so that two pictures stand side by side.
    size = f"width:min(100%,{width}px)"
    broad = "broad" if figure.get_figwidth() > 6.5 else None
    return tag("figure", shown, tag("figcaption", caption), class_=broad, style=size)


def page(title, children):
    """The whole document: no script, nothing from elsewhere."""
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    head = [
        Markup('<meta charset="utf-8">'),
        Markup(f'<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">'),
        Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
        Markup('<meta name="generator" content="bsdfkit">'),
        tag("title", title),
        tag("style", Markup(CSS)),
    ]
    return "<!DOCTYPE html>\n" + tag("html", tag("head", head), tag("body", tag("main", children)), lang="en") + "\n"


CSS = """
:root{--ink:#1a1a1a;--faint:#5c5c5c;--line:#d9d9d9;--good:#00664d;--fair:#8a5a00;--bad:#a33a00}
*{box-sizing:border-box}
body{margin:0;background:#fff;color:var(--ink);font:16px/1.5 system-ui,"DejaVu Sans","Segoe UI",Roboto,Helvetica,Arial,sans-serif}
main{max-width:66rem;margin:0 auto;padding:1.5rem 1.25rem 3rem}
h1{font-size:1.75rem;line-height:1.2;margin:.2rem 0;font-weight:600;overflow-wrap:anywhere}
h2{font-size:1.15rem;margin:2.2rem 0 .5rem;padding-top:.6rem;border-top:1px solid var(--line);font-weight:600}
h3{font-size:1rem;margin:1.2rem 0 .3rem;font-weight:600}
p{margin:.4rem 0;max-width:46rem}
.kind{color:var(--faint);margin:0}
.note,figcaption{color:var(--faint);font-size:.88rem}
.wide{overflow-x:auto;margin:.5rem 0}
table{border-collapse:collapse;font-size:.88rem;font-variant-numeric:tabular-nums}
th,td{text-align:left;vertical-align:top;padding:.28rem .9rem .28rem 0;border-bottom:1px solid var(--line)}
thead th{font-weight:600;color:var(--faint);vertical-align:bottom}
.facts th{font-weight:400;color:var(--faint);white-space:nowrap}
.facts td{overflow-wrap:anywhere}
.number{text-align:right;white-space:nowrap}
.badge{font-weight:600;white-space:nowrap}
.good{color:var(--good)}.fair{color:var(--fair)}.bad{color:var(--bad)}
figure{margin:1rem 0;break-inside:avoid}
figure img{display:block;width:100%;height:auto}
.gallery{display:flex;flex-wrap:wrap;gap:0 1.5rem;align-items:flex-end}
.gallery figure{flex:0 1 auto;max-width:100%}
pre{background:#f5f5f5;padding:.7rem .9rem;overflow-x:auto;font-size:.82rem;line-height:1.45}
code{font-family:ui-monospace,"DejaVu Sans Mono",Menlo,Consolas,monospace}
ul{margin:.3rem 0;padding-left:1.2rem;max-width:50rem}
li{margin:.15rem 0;overflow-wrap:anywhere}
dl{max-width:50rem;font-size:.88rem}dt{font-weight:600;margin-top:.5rem}dd{margin:0;color:var(--faint)}
@media(max-width:40rem){body{font-size:15px}main{padding:1rem}h1{font-size:1.4rem}}
@media print{
@page{margin:15mm}
body{font-size:9.5pt}main{max-width:none;padding:0}
h2,h3,.note{break-after:avoid}h2{margin-top:1.2rem}tr,pre{break-inside:avoid}pre{white-space:pre-wrap}
.wide{overflow:visible}table{font-size:8pt}th,td{padding:.15rem .5rem .15rem 0}
figure img{max-height:105mm;width:auto!important;max-width:100%}.gallery figure{width:47%!important}.gallery figure.broad{width:100%!important}
}
"""
