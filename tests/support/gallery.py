"""The gallery of custom questions in docs/questions/gallery."""

from tests.support import ROOT

GALLERY = {
    "acceleration": "planar-2r", "axis-in-the-base-frame": "elbow-3r", "ellipse-area": "planar-2r",
    "load-torques": "planar-2r", "middle-of-a-link": "elbow-3r", "near-a-singularity": "planar-2r",
    "own-robot": "elbow-3r", "parallel-columns": "planar-3r", "self-motion": "planar-3r",
    "stretched-height": "elbow-3r",
    "tip-speed": "polar-rp", "why-not": "scara", "wrist-centre": "scara",
}  # fmt: skip
"""The questions of the gallery, each with a family that it suits."""
GALLERY_FOLDER = ROOT / "docs" / "questions" / "gallery"
CHAPTER_ARMS = ("near-a-singularity",)
"""The questions that need the chapter's own arm (`variation = "chapter"`)."""
