"""Make Django's settings from the options of `qdot serve`. Call `configure` before anything else of this package."""

from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import SplitResult, unquote, urlsplit

import django
from django.conf import settings
from django.core.management.utils import get_random_secret_key

from qdot.exercises.assignment.release import ONLINE_FOLDER
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.common.parallel import CORE_COUNT
from qdot.exercises.writing.render import find_folder

DATABASE_FILE = "database.sqlite3"


@dataclass(frozen=True)
class ServiceOptions:
    """The options of the service.

    `folders` are the folders of the assignments. `database` is an address such as postgresql://user@host/name; ""
    stands for SQLite in the first folder. `url` is the address at which browsers reach the service, with https unless
    it is on this machine. `jobs` is the number of processes that judge typed answers.
    """

    folders: tuple[Path, ...]
    database: str = ""
    url: str = "http://127.0.0.1:8000"
    jobs: int = CORE_COUNT

    @property
    def online_folder(self) -> Path:
        """The folder for what the service itself stores on disk."""
        return self.folders[0] / ONLINE_FOLDER


def find_options() -> ServiceOptions:
    """Return the options with which the service was configured."""
    options: ServiceOptions = getattr(settings, "QDOT")  # noqa: B009 - mypy knows only Django's own settings
    return options


def configure(options: ServiceOptions) -> None:
    """Configure Django for this process. Raises QdotError for a wrong address of a database or of the service."""
    address = _parse_url(options.url)
    is_secure = address.scheme == "https"
    cookie_prefix = "__Host-" if is_secure else ""  # no other host can set such cookies
    options.online_folder.mkdir(mode=0o700, exist_ok=True)
    settings.configure(
        SECRET_KEY=_read_session_key(options.online_folder / "session-key.txt"),
        ALLOWED_HOSTS=[address.hostname],
        CSRF_TRUSTED_ORIGINS=[f"{address.scheme}://{address.netloc}"],
        ROOT_URLCONF="qdot.grader.serve.urls",
        DATABASES={"default": _describe_database(options)},
        DEFAULT_AUTO_FIELD="django.db.models.BigAutoField",
        USE_TZ=True,
        INSTALLED_APPS=[
            *("django.contrib.contenttypes", "django.contrib.auth", "django.contrib.sessions"),
            *("django_tasks", "django_tasks_db", "lti_tool", "qdot.grader.serve"),
        ],
        MIDDLEWARE=[
            "django.middleware.security.SecurityMiddleware",
            "qdot.grader.serve.headers.HeadersMiddleware",
            "whitenoise.middleware.WhiteNoiseMiddleware",
            "qdot.grader.serve.frame_requests.FrameSessionMiddleware",
            "django.contrib.sessions.middleware.SessionMiddleware",
            "django.middleware.common.CommonMiddleware",
            "django.middleware.csrf.CsrfViewMiddleware",
            "qdot.grader.serve.errors.RefusalMiddleware",
        ],
        SESSION_ENGINE="django.contrib.sessions.backends.db",
        SESSION_COOKIE_NAME=f"{cookie_prefix}sessionid",
        SESSION_COOKIE_SECURE=is_secure,
        SESSION_COOKIE_SAMESITE="None" if is_secure else "Lax",  # other cookies are not sent in a frame
        CSRF_COOKIE_NAME=f"{cookie_prefix}csrftoken",
        CSRF_COOKIE_SECURE=is_secure,
        CSRF_COOKIE_SAMESITE="None" if is_secure else "Lax",
        SECURE_PROXY_SSL_HEADER=("HTTP_X_FORWARDED_PROTO", "https") if is_secure else None,
        SECURE_CONTENT_TYPE_NOSNIFF=True,
        TASKS={"default": {"BACKEND": "django_tasks_db.DatabaseBackend", "QUEUES": ["default"]}},
        STATIC_URL="/static/",
        STATIC_ROOT=find_folder("site_dist", "site/dist"),
        WHITENOISE_IMMUTABLE_FILE_TEST=r"^/static/assets/",  # Vite's names change with the content
        CSRF_FAILURE_VIEW="qdot.grader.serve.errors.report_forged_request",
        DATA_UPLOAD_MAX_MEMORY_SIZE=1_000_000,
        FILE_UPLOAD_MAX_MEMORY_SIZE=1_000_000,
        CACHES={
            "default": {
                "BACKEND": "django.core.cache.backends.locmem.LocMemCache",
                "OPTIONS": {"MAX_ENTRIES": 100_000},
            },
            "pages": {
                "BACKEND": "django.core.cache.backends.filebased.FileBasedCache",
                "LOCATION": options.online_folder / "pages",
                "OPTIONS": {"MAX_ENTRIES": 20_000},
            },
        },
        LOGGING={
            "version": 1,
            "disable_existing_loggers": False,
            "handlers": {"stderr": {"class": "logging.StreamHandler"}},
            "loggers": {
                "django": {"handlers": ["stderr"], "level": "ERROR", "propagate": False},
                "django.security.DisallowedHost": {"level": "CRITICAL"},  # anybody can cause these
                "django.request": {"level": "CRITICAL"},  # would log addresses with tokens; `errors` logs failures
                "waitress.queue": {"level": "ERROR"},  # warnings about the number of waiting requests
                "qdot": {"handlers": ["stderr"], "level": "INFO"},
            },
        },
        QDOT=replace(options, url=address.geturl()),
    )
    django.setup()


def _parse_url(url: str) -> SplitResult:
    """Return the address of the service without a final slash. Raises QdotError."""
    try:
        address = urlsplit(url.removesuffix("/"))
        is_usable = address.scheme in ("http", "https") and bool(address.hostname) and address.port != 0
    except ValueError:
        is_usable = False
    if not is_usable:
        raise QdotError(f"--url {url!r} is not a whole address; expected one as in https://qdot.example.edu")
    if address.path or address.query or address.fragment or "@" in address.netloc:
        raise QdotError(f"--url {url!r}: qdot needs a host of its own; leave out everything after the host and port")
    return address


def _read_session_key(path: Path) -> str:
    """Return the key that signs sessions; it is made when the service starts for the first time."""
    if not path.exists():
        write_atomically(path, get_random_secret_key(), 0o600)
    return path.read_text(encoding="utf-8")


def _describe_database(options: ServiceOptions) -> dict[str, object]:
    """Return Django's description of the database. Raises QdotError for an address of another kind."""
    if not options.database:
        return {
            "ENGINE": "django.db.backends.sqlite3",
            "NAME": options.online_folder / DATABASE_FILE,
            "OPTIONS": {
                "transaction_mode": "IMMEDIATE",
                "timeout": 20,
                "init_command": "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL",
            },
        }
    address = urlsplit(options.database)
    name = address.path.lstrip("/")
    if address.scheme not in ("postgresql", "postgres") or not name:
        raise QdotError("--database: expected an address, as in postgresql://user:password@host/qdot")
    user, password = (unquote(text or "") for text in (address.username, address.password))
    return {
        "ENGINE": "django.db.backends.postgresql", "NAME": name, "USER": user, "PASSWORD": password,
        "HOST": address.hostname or "", "PORT": str(address.port or ""), "CONN_MAX_AGE": 60, "CONN_HEALTH_CHECKS": True,
    }  # fmt: skip
