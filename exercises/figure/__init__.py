"""Draw an arm from its DH table as in a robotics textbook: numeric shapes, SVG, and a description in words.

Planar arms are drawn flat, seen perpendicular to their plane. Spatial arms are drawn in one fixed axonometric view. If
a pose is given, links and axes may overlap; then the view that separates them best is used, with fewer names. For joint
i, the drawing shows the entry of the table, theta_i or d_i with its offset. Differences in length are reduced, so that
small lengths are visible.

    arm_figure              the figure of an arm, and figures made of several drawings
    shapes, lettering       plain shapes in pixels; symbols, lengths and angles as text
    view                    from metres to pixels
    plane, pose             the usual view of an arm; the pose in which it is drawn, or the best view of a given pose
    model                   one arm that is drawn for all arms that differ only in their labels
    arm_parts, frames       links and joints, and the scale that fits; axes, origins and the base's position
    places, labels          the lines of a drawing and the places for one label; the layout of all labels
    small                   thumbnails, and singular configurations beside a regular one
    tikz, words             the drawing for LaTeX; its description in words
"""
