"""Sign in a person who opens qdot in a course of a platform: login, launch and the public keys.

The platform sends the browser to /lti/login. qdot sends it back with a `state` and a `nonce`. Then the platform posts a
signed message to /lti/launch. The state is a signed time that only this browser has as a cookie; the nonce is
computed from the state. So qdot stores nothing for a login, and accepts a message once, from the right browser.

Some browsers store no cookies in a frame. A page of qdot then puts a proof, which is also computed from the state, into
the storage that the platform offers to pages in its frames. Another page reads the proof there, and sends it with the
message (1EdTech: LTI OIDC Login with LTI Client Side postMessages).
"""

import re
import secrets
import threading
from typing import Self
from urllib.parse import urlencode
from uuid import UUID

import jwt
from django.core import signing
from django.core.cache import cache
from django.db import transaction
from django.http import HttpRequest, HttpResponse, HttpResponseRedirect, JsonResponse
from django.shortcuts import get_object_or_404
from django.utils import timezone
from django.utils.crypto import constant_time_compare, salted_hmac
from django.views.decorators.csrf import csrf_exempt
from django.views.decorators.http import require_POST
from lti_tool.models import Key, LtiContext, LtiLaunch, LtiLineItem, LtiRegistration
from lti_tool.utils import DjangoToolConfig, sync_data_from_launch
from pylti1p3.contrib.django import DjangoMessageLaunch, DjangoOIDCLogin
from pylti1p3.contrib.django.request import DjangoRequest
from pylti1p3.contrib.django.session import DjangoSessionService
from pylti1p3.exception import LtiException, OIDCException

from qdot.exercises.common.console import escape_controls
from qdot.grader.serve.class_list import load_assignments
from qdot.grader.serve.errors import Refused, logger
from qdot.grader.serve.frame_sessions import is_from_own_page, use_frame_session
from qdot.grader.serve.html_pages import render_page
from qdot.grader.serve.lti.choosing import begin_choosing
from qdot.grader.serve.lti.columns import find_resource_id, make_path, save_column
from qdot.grader.serve.lti.connection import PLATFORM_ERRORS, PlatformSession, make_connector, renew_keys
from qdot.grader.serve.lti.outbox import update_scores
from qdot.grader.serve.lti.people import find_role, save_person
from qdot.grader.serve.lti.registering import connect_course
from qdot.grader.serve.models import Classroom, Person
from qdot.grader.serve.settings import find_options
from qdot.grader.serve.sign_in import sign_in

CLOCK_SKEW = 60
"""Maximum difference in seconds between the clocks of the platform and of this machine."""
LOGIN_SECONDS = 300
"""Maximum number of seconds from login to launch; the platform may ask for a password in between."""
KEY_SECONDS = 3600
"""Number of seconds for which the public keys of a platform are cached."""
SECONDS_BETWEEN_KEYS = 10
"""Minimum number of seconds before another message with an unknown key makes qdot fetch the keys again."""
ALGORITHM = "RS256"
_REQUIRED_CLAIMS = ["exp", "iat", "iss", "aud", "sub", "nonce"]
_CLAIM_PREFIX = "https://purl.imsglobal.org/spec/lti/claim/"
_NOT_VERIFIED = "qdot couldn't verify this launch. Open the activity again from your course."
_NEW_TAB_PARAMETER = "lti1p3_new_window"
_FRAME_NAME = re.compile(r"[\w.-]{1,80}", re.ASCII)
"""Matches the name of a frame as a platform gives it; it is part of the name of a cookie."""
_MALFORMED_MESSAGE_ERRORS = (LookupError, TypeError, ValueError, AttributeError)
"""The exceptions that the library raises for a message that doesn't have the agreed form."""

_fetches = threading.BoundedSemaphore(4)
"""Held while a platform's keys are fetched, so that a platform that doesn't answer blocks only a few requests."""


def _make_signer() -> signing.TimestampSigner:
    return signing.TimestampSigner(sep=".", salt="qdot.lti.state")


def compute_nonce(state: str) -> str:
    """Return the nonce of a login; nobody without the key of this service can compute it."""
    return salted_hmac("qdot.lti.nonce", state, algorithm="sha256").hexdigest()


def compute_proof(state: str) -> str:
    """Return the proof that a browser began a login. Only this browser gets it, and no address contains it."""
    return salted_hmac("qdot.lti.proof", state, algorithm="sha256").hexdigest()


def read_state(state: str) -> list[str]:
    """Return what a state contains: the platform's number, and the name of its frame for storage if it has one.

    Raises LtiException if the login is too old.
    """
    try:
        return _make_signer().unsign(state.removeprefix("state-"), max_age=LOGIN_SECONDS).split("~")[1:]
    except signing.BadSignature as error:
        raise LtiException("the login is too old, or not ours") from error


class NoStorage(DjangoSessionService):
    """Stores nothing for a login: PyLTI1p3 would make a session for every stranger."""

    def save_nonce(self, nonce: str) -> None:
        """Store nothing, because the nonce is computed from the state."""


class Login(DjangoOIDCLogin):
    """The answer to a platform that begins a login, with a state and a nonce of ours."""

    state = ""

    def _get_uuid(self) -> str:
        """Return a signed state; PyLTI1p3 adds the prefix "state-"."""
        frame = self._get_request_param("lti_storage_target") or ""
        parts = [secrets.token_urlsafe(16), str(self._tool_config.registration.pk)]
        signed = _make_signer().sign("~".join([*parts, frame] if _FRAME_NAME.fullmatch(frame) else parts))
        self.state = f"state-{signed}"
        return signed

    def _generate_nonce(self) -> str:
        return compute_nonce(self.state)

    def set_cookies(self, response: HttpResponse) -> None:
        """Store the state as a cookie of the browser."""
        self._cookie_service.update_response(response)


class Launch(DjangoMessageLaunch):
    """A message from a platform, checked more strictly than PyLTI1p3 does."""

    def validate_state(self) -> Self:
        """Check that this browser began the login, a short time ago."""
        state, proof = (self._get_request_param(name) or "" for name in ("state", "proof"))
        read_state(state)
        if proof:
            if not (is_from_own_page(self._request._request) and constant_time_compare(proof, compute_proof(state))):
                raise LtiException("the proof is wrong, or comes from another page")
        elif not constant_time_compare(state, self._cookie_service.get_cookie(state) or ""):
            raise LtiException("the browser has no cookie of this login")
        return self

    def validate_nonce(self) -> Self:
        """Check that the message answers this login."""
        if not constant_time_compare(str(self._jwt["body"]["nonce"]), compute_nonce(self._get_request_param("state"))):
            raise LtiException("the nonce is wrong")
        return self

    def get_public_key(self) -> tuple[str, str]:
        """Return the key that signed the message; if it isn't among the stored ones, the platform has new keys."""
        platform = self._tool_config.registration
        cache_name = f"lti-keys-{platform.pk}"
        stored_keys = cache.get(cache_name)
        if stored_keys is not None:
            self._registration.set_key_set(stored_keys)
            try:
                return super().get_public_key()
            except LtiException:
                if not cache.add(f"lti-new-keys-{platform.pk}", True, SECONDS_BETWEEN_KEYS):
                    raise
        if not _fetches.acquire(timeout=1):
            raise LtiException("the platform's keys are being fetched, which takes long")
        try:
            keys = self.fetch_public_key(platform.keyset_url)
        finally:
            _fetches.release()
        cache.set(cache_name, keys, KEY_SECONDS)
        self._registration.set_key_set(keys)
        return super().get_public_key()

    def validate_jwt_signature(self) -> Self:
        """Check the signature, the audience, the issuer and the times, and that the message is new."""
        key, _ = self.get_public_key()
        client_id = self._registration.get_client_id()
        try:
            claims = jwt.decode(
                self._get_id_token(), key, algorithms=[ALGORITHM], audience=client_id, leeway=CLOCK_SKEW,
                issuer=self._registration.get_issuer(), options={"require": _REQUIRED_CLAIMS},
            )  # fmt: skip
        except jwt.InvalidTokenError as error:
            raise LtiException(f"the message is not valid: {error}") from error
        # With several audiences, the claim azp names the tool that the message is for.
        has_one_audience = isinstance(claims["aud"], str) or len(claims["aud"]) == 1
        if claims.get("azp", client_id if has_one_audience else "") != client_id:
            raise LtiException("the message is for another tool")
        if not cache.add(f"lti-nonce-{claims['nonce']}", True, LOGIN_SECONDS + CLOCK_SKEW):
            raise LtiException("the message was used before")
        self._jwt["body"] = claims
        return self

    def save_launch_data(self) -> Self:
        """Store nothing, because qdot's tables have what it needs from the message."""
        return self


def show_keys(_: HttpRequest) -> HttpResponse:
    """Return the public keys of this service (a JSON Web Key Set)."""
    renew_keys(timezone.now())
    return JsonResponse(Key.objects.as_jwks())


@csrf_exempt
def login(request: HttpRequest, uuid: UUID) -> HttpResponse:
    """Answer a platform that begins a login: by a page that tries cookies or, in a new tab, by a redirection."""
    platform = get_object_or_404(LtiRegistration.objects.active(), uuid=uuid)
    defaults = {"client_id": platform.client_id}  # not every platform sends it
    answer = Login(DjangoRequest(request, default_params=defaults), DjangoToolConfig(platform.uuid), NoStorage(request))
    try:
        url = answer.get_redirect_object(f"{find_options().url}/lti/launch").get_redirect_url()
    except OIDCException as error:
        raise Refused(400, _NOT_VERIFIED) from error
    parameters = {**request.GET.dict(), **request.POST.dict()}
    response: HttpResponse = HttpResponseRedirect(url)
    if _NEW_TAB_PARAMETER not in parameters:
        tab = f"{request.path}?{urlencode({**parameters, _NEW_TAB_PARAMETER: '1'})}"
        response = _send_page(request, answer.state, url=url, tab=tab, proof=compute_proof(answer.state))
    answer.set_cookies(response)
    return response


def _send_page(
    request: HttpRequest, state: str, *, url: str = "", tab: str = "", proof: str = "", id_token: str = ""
) -> HttpResponse:
    """Return the page that puts a proof into the platform's storage if necessary, before the browser goes to `url`.

    If there is an `id_token`, the signed message, return the page that reads the proof and sends both to qdot.
    """
    platform_id, *frames = read_state(state)
    platform = get_object_or_404(LtiRegistration.objects.active(), pk=platform_id).auth_url
    values = {"state": state, "url": url, "tab": tab, "proof": proof, "id_token": id_token, "frame": "".join(frames)}
    return render_page(request, "serve/launch.html.j2", title="qdot", platform=platform, **values)


@csrf_exempt
@require_POST
def launch(request: HttpRequest) -> HttpResponse:
    """Sign in the person who opened a launch, and redirect to the launched page."""
    message = Launch(request, DjangoToolConfig(), requests_session=PlatformSession())
    state, proof = request.POST.get("state", ""), request.POST.get("proof")
    try:
        if not proof and f"lti1p3-{state}" not in request.COOKIES and len(read_state(state)) > 1:
            return _send_page(request, state, id_token=request.POST["id_token"])
        message.validate()
        if proof:
            use_frame_session(request)
        response = _open_launch(request, LtiLaunch(message))
    except (LtiException, *_MALFORMED_MESSAGE_ERRORS) as error:
        logger.warning("a launch was refused: %s", escape_controls(f"{type(error).__name__}: {error}")[:300])
        raise Refused(400, _NOT_VERIFIED) from error
    response.delete_cookie(f"lti1p3-{state}", samesite="None" if request.is_secure() else None)
    return response


def _open_launch(request: HttpRequest, lti_launch: LtiLaunch) -> HttpResponse:
    """Sign in the person of a verified launch, and return a redirection to the launched page. Raises Refused."""
    if lti_launch.context_claim is None:
        raise Refused(400, "Open qdot in a course.")
    role = find_role(lti_launch.roles_claim)
    with transaction.atomic():
        sync_data_from_launch(lti_launch)
        classroom = _find_classroom(lti_launch.context, role)
    if role is None:
        raise Refused(403, "Your platform says that you are neither a student nor a teacher of this course.")
    if not (classroom.is_connected and lti_launch.context.deployment.is_active):
        advice = f"the person who runs qdot connects it with: qdot serve connect FOLDER --course {classroom.pk}"
        raise Refused(403, f"This course isn't connected to qdot yet; {advice}")
    identifier = (lti_launch.get_claim(f"{_CLAIM_PREFIX}lis") or {}).get("person_sourcedid")
    person = save_person(classroom, lti_launch.user, role, identifier)
    sign_in(request, person)
    if lti_launch.is_deep_link_launch:
        return begin_choosing(request, lti_launch, person)
    if lti_launch.is_submission_review_launch:
        return HttpResponseRedirect(_find_review(lti_launch, person))
    resource_id = find_resource_id(str(lti_launch.get_claim(f"{_CLAIM_PREFIX}target_link_uri")))
    assignments = load_assignments()
    if not resource_id and len(assignments) == 1:
        resource_id = next(iter(assignments))  # as after a teacher has typed the address of the service
    key = resource_id.partition("/")[0]
    if key not in assignments:
        return HttpResponseRedirect("/")
    _store_column(lti_launch, classroom, resource_id)
    update_scores(person, key)
    return HttpResponseRedirect(f"/a/{key}/class/" if role == Person.Role.STAFF else make_path(resource_id))


def _find_classroom(context: LtiContext, role: Person.Role | None) -> Classroom:
    """Return the class of a course. The first course of a platform in which a teacher opens qdot is connected."""
    classroom, _ = Classroom.objects.get_or_create(lti_context=context)
    classroom.lti_context, classroom.title = context, context.title or context.label
    if role == Person.Role.STAFF:
        classroom.list_due = timezone.now()
        platform = LtiRegistration.objects.select_for_update().get(pk=context.deployment.registration_id)
        courses = Classroom.objects.filter(lti_context__deployment__registration=platform)
        if not courses.filter(is_connected=True).exists():
            connect_course(classroom)
    classroom.save()
    return classroom


def _store_column(lti_launch: LtiLaunch, classroom: Classroom, resource_id: str) -> None:
    """Store the gradebook column of the launched activity, and fill it in if it is new."""
    connector = make_connector(lti_launch.registration, timezone.now())
    try:
        is_new = save_column(lti_launch, lti_launch.context, resource_id, connector)
    except PLATFORM_ERRORS as error:
        logger.warning("a column of the gradebook was not made: %s", escape_controls(str(error))[:300])
        return
    if is_new:
        key = resource_id.partition("/")[0]
        for person in classroom.people.filter(submissions__assignment=key).distinct():
            update_scores(person, key)


def _find_review(lti_launch: LtiLaunch, person: Person) -> str:
    """Return the address of the work that a person opened from the gradebook; students see their own."""
    column = LtiLineItem.objects.filter(url=lti_launch.ags_claim["lineitem"], context=lti_launch.context).first()
    if column is None:
        return "/"
    if person.role != Person.Role.STAFF:
        return make_path(column.resource_id)
    sub = str(lti_launch.get_claim(f"{_CLAIM_PREFIX}for_user")["user_id"])
    student = person.classroom.people.filter(lti_user__sub=sub).first()
    query = f"?student={student.pk}" if student else ""
    return f"/a/{column.resource_id.partition('/')[0]}/class/{query}"
