"""Small files that replace the scripts and styles of `npm run build` in tests that run no page."""

from pathlib import Path

from qdot.exercises.site.pages import SCRIPT_SOURCES, Assets


def write_stand_in_assets(folder: Path) -> Assets:
    (folder / "assets").mkdir(parents=True)
    for name in (*(f"{entry}.js" for entry in SCRIPT_SOURCES), "shared.js", "site.css"):
        (folder / "assets" / name).write_text(f"/* {name} */\n")
    return Assets(
        {name: f"assets/{name}.js" for name in SCRIPT_SOURCES},
        {name: [] if name == "pages" else ["assets/shared.js"] for name in SCRIPT_SOURCES},
        {name: ["assets/site.css"] for name in SCRIPT_SOURCES},
        sorted((folder / "assets").iterdir()),
        folder,
    )
