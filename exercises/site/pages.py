"""Render the pages of the site from templates/site: the home page, practice, the book's examples, the documentation.

All links are relative, so that the site works from any folder of any file server.
"""

import json
import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from qdot.exercises.chapter import make_planar_2r, make_scorbot_arm
from qdot.exercises.common.errors import QdotError
from qdot.exercises.figure.arm_figure import draw_figure_svg
from qdot.exercises.notebook.notebook import CHECK_PAGE
from qdot.exercises.site.arms import make_gallery_page
from qdot.exercises.site.chapter import make_arm_data, make_chapter_pages
from qdot.exercises.site.guide import COMMANDS, REPLACED_PAGES, arrange_pages
from qdot.exercises.site.page import Page, translate_message
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.render import find_folder, find_template_folder, render

SCRIPT_SOURCES = {
    "practice": "src/practice/main.tsx", "learn": "src/learn/main.tsx", "own": "src/own/main.tsx",
    "course": "src/course/main.tsx", "check": "src/check/main.tsx", "package": "src/course/package.tsx",
    "serve": "src/serve/main.ts", "pages": "src/pages/main.ts",
}  # fmt: skip
"""The source of each script that pages load.

"package" is for packages for learning platforms (`exports.scorm`), "serve" for the pages of `qdot serve`, and "pages"
for pages of text.
"""
NODE_VERSION = "Node 20.19 or later"
"""The versions of Node that build the scripts, as in site/package.json."""
HOME_PAGE_POSE = {"theta1": math.radians(15), "theta2": math.radians(100)}
"""The initial joint values of the arm on the home page; readers can drag P from there across the drawing."""
LESSON_POSE = {"theta1": math.radians(60), "theta2": math.radians(100)}
"""The initial joint values of the arm in the lessons; they fulfil none of the goals."""
MAX_CHECKED_MEGABYTES = 50
"""Maximum size of a notebook that the page for students' notebooks opens: small enough for the memory of a phone."""
MIN_LISTED_HEADINGS = 3
"""A page of the documentation with at least this many headings gets a list of them."""


@dataclass(frozen=True)
class Assets:
    """The built scripts and styles of the site, and all `files` of their `folder`.

    The other fields map each name in SCRIPT_SOURCES to the path of its script, and to the paths of the scripts
    (`modules`) and styles that this script imports.
    """

    scripts: Mapping[str, str]
    modules: Mapping[str, Sequence[str]]
    styles: Mapping[str, Sequence[str]]
    files: Sequence[Path]
    folder: Path


def render_licences(folder: Path) -> str:
    """Return the licences of the libraries in the scripts as Markdown, from the files that Vite wrote to a folder."""
    paths = {name: folder / ".vite" / f"{name}.md" for name in ("licences", "notices")}
    texts = {name: path.read_text(encoding="utf-8") if path.exists() else "" for name, path in paths.items()}
    _, _, libraries = texts["licences"].partition("\n## ")
    return render("site/licences.md.j2", licences=f"## {libraries}".strip(), notices=texts["notices"].strip())


def find_docs_folder() -> Path | None:
    """Return the folder of the documentation, or None if there is none."""
    return find_folder("site_docs", "docs")


def find_assets() -> Assets:
    """Return the built scripts and styles. Raises QdotError if they are missing or outdated."""
    folder = find_folder("site_dist", "site/dist")
    if folder is not None:
        return read_assets(folder)
    raise QdotError(f"the site's scripts, which pages and SCORM packages need, are not there; {_explain_build()}")


def _explain_build() -> str:
    """Return how to get the built scripts, in a checkout or after an installation from the source."""
    source_folder = Path(__file__).resolve().parents[2] / "site"
    if (source_folder / "package.json").is_file():
        return f"install {NODE_VERSION}, then run `make site-scripts` in {source_folder.parent}"
    return (
        f"qdot was installed from its source on a machine without Node: install {NODE_VERSION}, then install qdot "
        "again, or install a wheel that contains the scripts (docs/install.md)"
    )


def read_assets(folder: Path) -> Assets:
    """Return the scripts and styles in a folder that Vite wrote. Raises QdotError if they belong to another version."""
    manifest = _read_manifest(folder)
    scripts = {name: manifest[source]["file"] for name, source in SCRIPT_SOURCES.items()}
    modules = {name: _list_imports(manifest, source) for name, source in SCRIPT_SOURCES.items()}
    styles = {name: _list_styles(manifest, source) for name, source in SCRIPT_SOURCES.items()}
    files = sorted(path for path in folder.rglob("*") if path.is_file() and ".vite" not in path.parts)
    return Assets(scripts, modules, styles, files, folder)


def _read_manifest(folder: Path) -> dict[str, Any]:
    """Return Vite's manifest of the built scripts. Raises QdotError if the manifest lacks a script of the pages."""
    path = folder / ".vite" / "manifest.json"
    try:
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        content = {}
    missing_sources = [source for source in SCRIPT_SOURCES.values() if source not in content]
    if missing_sources:
        raise QdotError(
            f"the site's scripts in {folder} are incomplete or from another version of qdot; these are missing: "
            f"{', '.join(missing_sources)}; {_explain_build()}"
        )
    return content


def _list_imports(manifest: Mapping[str, Mapping[str, Sequence[str]]], source: str) -> list[str]:
    """Return the static imports of a script; a page preloads them in parallel with the script."""
    names = manifest[source].get("imports", ())
    files = [file for name in names for file in (str(manifest[name]["file"]), *_list_imports(manifest, name))]
    return list(dict.fromkeys(files))


def _list_styles(manifest: Mapping[str, Mapping[str, Sequence[str]]], source: str) -> list[str]:
    """Return the styles of a script and of its static imports."""
    entry = manifest[source]
    imported_styles = [style for name in entry.get("imports", ()) for style in _list_styles(manifest, name)]
    return list(dict.fromkeys([*imported_styles, *entry.get("css", ())]))


def make_pages(
    docs: Path | None, command_reference: str, course: str, families: Collection[str], licences: str
) -> Iterator[Page]:
    """Yield every page of the site.

    - `docs`: the folder of the documentation, None for a site without documentation
    - `command_reference`: the body of the page on the command line
    - `course`: the title of an instructor's own site, "" for the public site
    - `families`: the families in the bank
    - `licences`: the licences of the libraries in the scripts, as Markdown
    """
    has_docs = docs is not None
    arm = make_planar_2r()
    arm_json = json.dumps(make_arm_data(arm) | {"pose": HOME_PAGE_POSE}, ensure_ascii=False)
    figure = draw_figure_svg(arm, pose=HOME_PAGE_POSE)
    home = render("site/index.html.j2", course=course, has_docs=has_docs, arm=arm_json, figure=figure)
    yield Page("index.html", course or "qdot", home, section="home", kind="home")
    practice = render("site/practice.html.j2", has_docs=has_docs)
    arms = {"plain": make_arm_data(arm) | {"pose": LESSON_POSE}, "elbow": make_arm_data(make_scorbot_arm())}
    learn = render("site/learn.html.j2", arms=json.dumps(arms, ensure_ascii=False))
    yield Page("learn.html", "Learn", learn, script="learn", section="learn", kind="practice")
    yield Page("practice.html", "Practise", practice, script="practice", section="practice", kind="practice")
    own_arm = render("site/own.html.j2", has_docs=has_docs)
    yield Page("own.html", "Your own arm", own_arm, script="own", section="own", kind="practice")
    check = render("site/check.html.j2", has_docs=has_docs, max_megabytes=MAX_CHECKED_MEGABYTES)
    yield Page(CHECK_PAGE, "Check your notebook", check, script="check")
    course_help = render("site/course.html.j2", has_docs=has_docs)
    yield Page("course.html", "In a course", course_help, script="course", kind="wide", allows_frames=True)
    yield Page("404.html", "There is no such page", render("site/missing.html.j2", root=""), is_error_page=True)
    yield Page("accessibility.html", "Accessibility", to_html(render("site/accessibility.md.j2")))
    yield Page("licences.html", "Licences", to_html(licences))
    yield from make_chapter_pages()
    if docs is not None:
        yield make_gallery_page(families)
        yield from _make_documentation_pages(docs, command_reference)


def _make_documentation_pages(docs: Path, command_reference: str) -> Iterator[Page]:
    """Yield the overview of the documentation, and each page that it lists."""
    groups = arrange_pages(docs)
    overview_body = render("site/docs.html.j2", groups=groups, translate=translate_message)
    yield Page("docs/index.html", "Documentation", overview_body, section="docs", kind="wide")
    for entries in groups.values():
        for entry in entries:
            path = docs / f"{entry.name}.md"
            content = command_reference if entry.name == COMMANDS else to_html(path.read_text(encoding="utf-8"))
            body = link_pages(content)
            shown_headings = find_headings(body) if len(find_headings(body)) >= MIN_LISTED_HEADINGS else []
            page_body = render(
                "site/doc.html.j2", body=body, groups=groups, entry=entry, headings=shown_headings,
                translate=translate_message,
            )  # fmt: skip
            yield Page(f"docs/{entry.name}.html", entry.title, page_body, section="docs", kind="docs")


def link_pages(body: str) -> str:
    """Return a page of docs/ with links to other pages of the site, and with anchors at its headings."""
    linked_body = re.sub(r'href="([\w-]+)\.md(#[\w-]*)?"', lambda m: f'href="{_write_address(m[1], m[2] or "")}"', body)
    return re.sub(r"<h([2-4])>(.*?)</h\1>", _add_anchor, linked_body)


def _write_address(name: str, anchor: str) -> str:
    """Return the address of a page of docs/ in the site, relative to the site's own folder docs/."""
    if name not in REPLACED_PAGES:
        return f"{name}.html{anchor}"
    if anchor == "#errata":
        return "../examples/errata.html"
    return f"../{REPLACED_PAGES[name]}{anchor}"


def _add_anchor(heading: re.Match[str]) -> str:
    """Return a heading with an anchor that is made from its text, as on GitHub."""
    heading_text = re.sub(r"<[^>]*>", "", heading[2]).lower()
    anchor = re.sub(r"[^\w\- ]", "", heading_text).strip().replace(" ", "-")
    return f'<h{heading[1]} id="{anchor}">{heading[2]}</h{heading[1]}>'


def find_headings(body: str) -> list[tuple[str, str]]:
    """Return the anchor and the text of each second-level heading of a page.

    >>> find_headings('<h2 id="a">An <code>A</code></h2>')
    [('a', 'An A')]
    """
    matches = re.findall(r'<h2 id="([^"]*)">(.*?)</h2>', body)
    return [(anchor, re.sub(r"<[^>]*>", "", text)) for anchor, text in matches]


def render_page(page: Page, assets: Assets, course: str, has_docs: bool = True) -> str:
    """Return the whole HTML of a page; the page links to the documentation only if the site has one (`has_docs`)."""
    root = "../" * page.path.count("/")
    return render(
        "site/page.html.j2", page=page, root=root, course=course, body=page.body, has_docs=has_docs,
        script=assets.scripts[page.script], modules=assets.modules[page.script], styles=assets.styles[page.script],
    )  # fmt: skip


def read_favicon() -> str:
    """Return the site's icon (SVG)."""
    return (find_template_folder() / "site" / "icon.svg").read_text(encoding="utf-8")
