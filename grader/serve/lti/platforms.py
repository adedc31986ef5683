"""The kinds of learning platforms: the addresses at which they answer, and where a person registers a tool.

In an address, {site} is the address of the platform itself, such as https://moodle.example.edu.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Platform:
    """A kind of platform, with its addresses; `steps` are instructions for registering a tool.

    `audience` is the audience of requests for access tokens if it isn't `token_url`.
    """

    title: str
    issuer: str
    auth_url: str
    token_url: str
    keys_url: str
    steps: str
    audience: str = ""
    is_dynamic: bool = True
    """Whether the platform can register a tool by itself, from one address."""


PLATFORMS = {
    "canvas": Platform(
        "Canvas",
        "https://canvas.instructure.com",
        "https://sso.canvaslms.com/api/lti/authorize_redirect",
        "https://sso.canvaslms.com/login/oauth2/token",
        "https://sso.canvaslms.com/api/lti/security/jwks",
        "Admin, Developer Keys, + LTI Key. Turn on all LTI Advantage services, set Privacy Level to Public, add the "
        "placement Assignment Selection with the message LtiDeepLinkingRequest, and switch the key on. The client "
        "ID is the number under Details. Then add the app to the account or the course: Settings, Apps, + App, By "
        "Client ID.",
    ),
    "moodle": Platform(
        "Moodle",
        "{site}",
        "{site}/mod/lti/auth.php",
        "{site}/mod/lti/token.php",
        "{site}/mod/lti/certs.php",
        "Site administration, Plugins, Activity modules, External tool, Manage tools. By itself: paste the "
        "registration address under Tool URL, press Add LTI Advantage, and activate the tool. By hand: configure a "
        "tool manually with LTI version 1.3 and public key type Keyset URL, tick Supports Deep Linking, turn on the "
        "services for grades and for names and roles, and share name and e-mail. The client ID is shown by View "
        "configuration details.",
    ),
    "brightspace": Platform(
        "Brightspace",
        "{site}",
        "{site}/d2l/lti/authenticate",
        "https://auth.brightspace.com/core/connect/token",
        "{site}/d2l/.well-known/jwks",
        "Admin Tools, Manage Extensibility, LTI Advantage, Register Tool. Tick Assignment and Grade Services, Deep "
        "Linking and Names and Role Provisioning Services. Then make a deployment of the tool that shares names and "
        "e-mail, and in it a link of type Deep Linking Quicklink.",
        audience="https://api.brightspace.com/auth/token",
    ),
    "blackboard": Platform(
        "Blackboard",
        "https://blackboard.com",
        "https://developer.blackboard.com/api/v1/gateway/oidcauth",
        "https://developer.blackboard.com/api/v1/gateway/oauth2/jwttoken",
        "https://developer.blackboard.com/api/v1/management/applications/{client_id}/jwks.json",
        "Register the tool at developer.blackboard.com; the application ID is the client ID. Then in Blackboard: "
        "Administrator Panel, Integrations, LTI Tool Providers, Register LTI 1.3 Tool. Share role, name and e-mail, "
        "allow grade service and membership service, and add a placement of type Deep Linking content tool.",
        is_dynamic=False,
    ),
    "sakai": Platform(
        "Sakai",
        "{site}",
        "{site}/imsoidc/lti13/oidc_auth",
        "{site}/imsblis/lti13/token",
        "{site}/imsblis/lti13/keyset",
        "Administration Workspace, External Tools, LTI Advantage Auto Provision: paste the registration address. "
        "Allow names, e-mail, class list, gradebook and content selection. By hand, give the addresses that Sakai "
        "shows for the tool.",
    ),
}
