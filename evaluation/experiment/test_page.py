"""The page: tables from Markdown, and figures that share one document."""

import re

import page
import tables

MARKDOWN = """# Title

Text with `code` & *stress*.

## The road, here

| case | RMS |
| --- | --- |
| a < b | 0.1 m |
"""


def test_page_holds_tables_and_figures_with_names_of_their_own(tmp_path):
    svg = '<?xml version="1.0"?><svg><path id="m"/><use href="#m" clip-path="url(#m)"/></svg>'
    for name, _ in page.FIGURES["The road"]:
        (tmp_path / name).write_text(svg)
    made = page.page(MARKDOWN, tmp_path)
    assert "<title>Title</title>" in made
    assert "<code>code</code> &amp; <em>stress</em>" in made
    assert "<th>RMS</th>" in made and "<td>a &lt; b</td><td>0.1 m</td>" in made
    ids = re.findall(r'\bid="([^"]+)"', made)
    assert len(ids) == len(set(ids)) == len(page.FIGURES["The road"])
    for used in re.findall(r'href="#([^"]+)"', made) + re.findall(r"url\(#([^)]+)\)", made):
        assert used in ids


def test_a_drive_without_a_result_is_listed_with_its_reason():
    assert tables.failures([], 3) == ""
    text = tables.failures([{"case": "car1_8mps", "seed": 6, "failed": "no\n  model"}], 3)
    assert "1 of 4 drives" in text and "| car1_8mps | 6 | no model |" in text
