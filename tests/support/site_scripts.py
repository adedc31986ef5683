"""Scripts and styles as `npm run build` would leave them, a few small files: for tests that need no page to run."""

from pathlib import Path

from qdot.exercises.site.pages import SCRIPT_SOURCES, Assets


def stand_in(folder: Path) -> Assets:
    """Write them below a folder, and return what `built_assets` would."""
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
