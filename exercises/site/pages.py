"""The pages of the site, rendered from templates/site: the landing page, practice, the book's examples, the docs.

A page links by relative addresses only, so that the site works from any folder of any file server.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from exercises.render import render, template_folder
from exercises.writing.markup import to_html

ENTRIES = {"practice": "src/practice/main.tsx", "pages": "src/pages/main.ts"}
DOCS = {
    "examples": "Examples 6.1 to 6.4", "families": "The arms", "questions": "The questions",
    "judging": "How an answer is judged", "mistakes": "Mistakes that are named", "hints": "Hints",
    "grading": "Grading a class", "submissions": "What students hand in", "sandbox": "Students' code, contained",
    "site": "The web site", "outlets": "Outlets", "structures": "How many arms there are",
}  # fmt: skip
"""Pages of docs/ with their titles, in this order; what else is there comes behind them, by its own heading."""


@dataclass(frozen=True)
class Assets:
    """The built scripts and styles: addresses of the script and the styles of each entry, and every file."""

    scripts: Mapping[str, str]
    styles: Mapping[str, Sequence[str]]
    files: Sequence[Path]
    folder: Path


def built_assets() -> Assets | None:
    """Return what `npm run build` made: inside the package (wheel) or in site/dist (checkout); None where it is not."""
    here = Path(__file__).parents[1]
    folder = next((f for f in (here / "site_dist", here.parent / "site" / "dist") if f.is_dir()), None)
    if folder is None:
        return None
    manifest = json.loads((folder / ".vite" / "manifest.json").read_text(encoding="utf-8"))
    entries = {name: manifest[source] for name, source in ENTRIES.items()}
    files = sorted(path for path in folder.rglob("*") if path.is_file() and ".vite" not in path.parts)
    styles = {name: _styles(manifest, source) for name, source in ENTRIES.items()}
    return Assets({name: entry["file"] for name, entry in entries.items()}, styles, files, folder)


def _styles(manifest: Mapping[str, Mapping[str, Sequence[str]]], source: str) -> list[str]:
    """Return the styles of an entry and of what it imports at once."""
    entry = manifest[source]
    found = [style for name in entry.get("imports", ()) for style in _styles(manifest, name)]
    return list(dict.fromkeys([*found, *entry.get("css", ())]))


@dataclass(frozen=True)
class Page:
    """A page: its path in the site, title, body, and the entry whose script it loads."""

    path: str
    title: str
    body: str
    entry: str = "pages"
    section: str = ""


def pages(docs: Path | None, commands: str, course: str) -> Iterator[Page]:
    """Yield every page. `commands` is Markdown on the command line; `course` the title of an instructor's own site."""
    yield Page(
        "index.html",
        course or "qdot",
        render("site/index.html.j2", course=course, has_docs=docs is not None),
        section="home",
    )
    yield Page(
        "practice.html", "Practise", render("site/practice.html.j2", has_docs=docs is not None), "practice", "practice"
    )
    yield Page("accessibility.html", "Accessibility", to_html(render("site/accessibility.md.j2")))
    if docs is not None:
        for name, title in doc_titles(docs).items():
            text = (docs / f"{name}.md").read_text(encoding="utf-8")
            yield Page(f"docs/{name}.html", title, linked(to_html(text)), section="docs")
        names = doc_titles(docs)
        yield Page("docs/index.html", "Documentation", render("site/docs.html.j2", docs=names), section="docs")
        yield Page("docs/commands.html", "The command line", to_html(commands), section="docs")


def doc_titles(docs: Path) -> dict[str, str]:
    """Return the pages of docs/ by name, with their titles, in the order of DOCS."""
    there = {path.stem: path for path in sorted(docs.glob("*.md"))}
    known = {name: title for name, title in DOCS.items() if name in there}
    return known | {name: _heading(path) for name, path in there.items() if name not in known}


def _heading(path: Path) -> str:
    found = re.search(r"^# (.+)$", path.read_text(encoding="utf-8"), re.MULTILINE)
    return found.group(1) if found else path.stem


def linked(page: str) -> str:
    """Return a page of docs/ with links to other pages as they are called on the site, and headings to jump to."""
    page = re.sub(r'href="([\w-]+)\.md(#[\w-]*)?"', lambda m: f'href="{m[1]}.html{m[2] or ""}"', page)
    page = re.sub(r'href="\.\./(?!\w+\.html)([^"]+)"', r'href="\1"', page)
    return re.sub(r"<h([2-4])>(.*?)</h\1>", _anchored, page)


def _anchored(heading: re.Match[str]) -> str:
    plain = re.sub(r"<[^>]*>", "", heading[2]).lower()
    anchor = re.sub(r"[^\w\- ]", "", plain).strip().replace(" ", "-")
    return f'<h{heading[1]} id="{anchor}">{heading[2]}</h{heading[1]}>'


def page_text(page: Page, assets: Assets, course: str, has_docs: bool = True) -> str:
    """Return the HTML of a page; without docs, nothing leads to them."""
    root = "../" * page.path.count("/")
    return render(
        "site/page.html.j2", page=page, root=root, course=course, body=page.body, has_docs=has_docs,
        script=assets.scripts[page.entry], styles=assets.styles[page.entry],
    )  # fmt: skip


def worker_text(files: Sequence[str], version: str) -> str:
    """Return the service worker: it keeps the pages, scripts and styles, and every problem that was opened."""
    return render("site/sw.js.j2", files=list(files), version=version)


def favicon() -> str:
    """Return the site's icon (SVG)."""
    return (template_folder() / "site" / "icon.svg").read_text(encoding="utf-8")
