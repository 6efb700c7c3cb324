"""The outcome as one HTML page that needs no other file: the tables, and the figures between them."""

import html
import re
import string

STYLE = """
body { font: 14px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 1250px; padding: 0 1em; }
table { border-collapse: collapse; margin: 1em 0; font-size: 12px; font-variant-numeric: tabular-nums; }
th, td { border: 1px solid #ccc; padding: 3px 7px; text-align: left; }
th { background: #f2f2f2; font-weight: 600; }
div.wide { overflow-x: auto; }
figure { margin: 1.5em 0; }
figcaption { color: #444; font-size: 12px; }
svg { max-width: 100%; height: auto; }
"""
PAGE = string.Template(
    '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><title>$title</title>'
    "<style>$style</style></head><body>\n$body\n</body></html>\n"
)
# After the section of this heading, figures and what they show.
FIGURES = {
    "The cars": [],
    "Measurement and loop": [
        ("loop.svg", "The loop on the road. In the yaw step the controller sees the true yaw."),
    ],
    "Design targets": [],
    "Yaw step": [("yaw_steps.svg", "Yaw over the step of 5° on the car, no sensor noise; first seed.")],
    "Ratios": [("ratios.svg", "Identified over rival; left of 1 the identified design is better.")],
    "The road": [
        ("paths.svg", "The road of each speed: double lane change and S-curve."),
        (
            "tracking_identified.svg",
            "Tracking with the controller designed on the identified plant; corrected GNSS, first seed.",
        ),
        (
            "tracking_bicycle.svg",
            "The same with the controller designed on the bicycle model of the data sheet, no lag.",
        ),
        ("road.svg", "Cross-track error of every contender; corrected GNSS, first seed."),
    ],
}


def inline(text):
    """Code spans and emphasis of a line."""
    text = re.sub(r"`([^`]*)`", r"<code>\1</code>", html.escape(text, quote=False))
    return re.sub(r"\*([^*]+)\*", r"<em>\1</em>", text)


def table(lines):
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    head, body = rows[0], rows[2:]

    def row(cells, tag):
        return "<tr>" + "".join(f"<{tag}>{inline(cell)}</{tag}>" for cell in cells) + "</tr>"

    lines = [row(head, "th"), *(row(cells, "td") for cells in body)]
    return '<div class="wide"><table>\n' + "\n".join(lines) + "\n</table></div>"


def figure(folder, name, caption, number):
    svg = (folder / name).read_text()
    # Names within the picture are made this picture's own: all share one document.
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r'\bid="', f'id="f{number}-', svg)
    svg = re.sub(r"url\(#", f"url(#f{number}-", svg)
    svg = re.sub(r'href="#', f'href="#f{number}-', svg)
    caption_text = html.escape(caption, quote=False)
    return f"<figure>{svg}<figcaption>{caption_text}</figcaption></figure>"


def block(text):
    if text.startswith("#"):
        level = len(text) - len(text.lstrip("#"))
        return f"<h{level}>{inline(text.lstrip('# '))}</h{level}>"
    if text.startswith("|"):
        return table(text.splitlines())
    return f"<p>{inline(text)}</p>"


def page(markdown, folder):
    """The page of results.md and the figures in a folder."""
    sections = re.split(r"(?m)^(?=## )", markdown)
    parts, number = [], 0
    for section in sections:
        parts += [block(text.strip()) for text in section.split("\n\n") if text.strip()]
        for start, figures in FIGURES.items():
            if section.startswith(f"## {start}"):
                for name, caption in figures:
                    number += 1
                    parts.append(figure(folder, name, caption, number))
    title = sections[0].splitlines()[0].lstrip("# ")
    return PAGE.substitute(title=html.escape(title), style=STYLE, body="\n".join(parts))
