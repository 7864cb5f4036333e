"""The commands that create and administer a forum; each test has its own forum."""

from __future__ import annotations

import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from agentrob.board.admin import local_admin, moderation
from agentrob.board.content import writes
from agentrob.board.content.rendered import Text
from agentrob.board.db.database import migrate, serving_lock
from agentrob.board.db.writer import Transaction
from agentrob.board.settings import BoardSettings
from agentrob.cli.main import cli
from agentrob.config.load import load
from agentrob.errors import AgentRobError, BoardError, ConfigError
from agentrob.model import AccountKind, EventKind, Role


class Shell:
    """A folder in which `agentrob init` was run."""

    def __init__(self, folder: Path) -> None:
        self.config = folder / "agentrob.toml"
        self.folder = folder

    def run(self, *words: str) -> str:
        done = CliRunner().invoke(cli, [*words, "--config", str(self.config)])
        if done.exception is not None and not isinstance(done.exception, SystemExit):
            raise done.exception
        assert done.exit_code == 0, done.output
        return done.output

    def board(self, *words: str) -> str:
        return self.run("board", *words)

    @property
    def settings(self) -> BoardSettings:
        loaded = load(self.config)
        return BoardSettings.from_config(loaded.board, loaded.data_dir)


@pytest.fixture(scope="module")
def new_forum(tmp_path_factory: pytest.TempPathFactory) -> Shell:
    """Create a new forum. Tests change copies of it."""
    shell = Shell(tmp_path_factory.mktemp("begun"))
    options = ["--url", "https://forum.example.org", "--data", str(shell.folder / "data"), "--invites", "20"]
    said = shell.run("init", "--admin", "chief", *options)
    assert re.search(r"once, within a day: https://forum.example.org/password/[\w-]{43}\n", said)
    assert re.search(r"invite 20 members within 30 days: https://forum.example.org/invite/[\w-]{43}\n", said)
    shell.board("account", "add", "quadruped", "--kind", "robot_agent")
    shell.board("account", "add", "ann", "--role", "operator")
    return shell


@pytest.fixture
def shell(new_forum: Shell, tmp_path: Path) -> Shell:
    shell = Shell(Path(shutil.copytree(new_forum.folder, tmp_path / "lab")))
    shell.config.write_text(new_forum.config.read_text().replace(str(new_forum.folder), str(shell.folder)))
    return shell


def post(shell: Shell, body: str) -> tuple[str, str]:
    """Start a topic as ann; return the ids of the topic and its post."""
    ann = local_admin.find_account(shell.settings, "ann")
    with local_admin.writing(shell.settings) as connection:
        made = writes.create_topic(
            Transaction(connection), "talk", "A topic", writes.Draft(ann, Text(body).rendered(()))
        )
    return made.topic.id, made.post.id


def test_a_new_forum_is_safe_by_default_and_cannot_be_created_twice(shell: Shell) -> None:
    assert (shell.settings.sign_up, shell.settings.public_read, shell.settings.secure) == (False, False, True)
    assert shell.settings.limits.posts > 0
    chief = local_admin.find_account(shell.settings, "chief")
    assert (chief.role, chief.kind) == (Role.ADMIN, AccountKind.HUMAN)
    with pytest.raises(AgentRobError, match="already exists"):
        shell.run("init", "--admin", "other")
    assert "password" not in shell.config.read_text()


def test_accounts_and_their_tokens(shell: Shell) -> None:
    assert "ann\thuman\toperator\n" in shell.board("account", "list")
    assert shell.board("account", "display", "ann", "Ann Li") == "ann: Ann Li\n"
    with pytest.raises(BoardError, match="looks like the robot"):
        shell.board("account", "display", "ann", "Qu\u0430druped")
    assert shell.board("account", "token", "ann", "--label", "sensor", "--scope", "read").startswith("agentrob_")
    line = next(t for t in shell.board("account", "tokens", "ann").splitlines() if "sensor" in t)
    token, label, scopes, _, state = line.split("\t")
    assert (label, scopes, state) == ("sensor", "read", "good")
    shell.board("account", "revoke-one", token)
    assert f"{token}\tsensor" in (after := shell.board("account", "tokens", "ann"))
    assert "revoked" in after
    assert "/password/" in shell.board("account", "password", "ann")
    assert shell.board("account", "sign-out", "ann") == "0 sessions ended\n"


def test_boards_robots_and_invites(shell: Shell) -> None:
    made = shell.board("boards", "add", "lab", "--name", "Lab", "--read", "operator", "--post", "operator")
    assert "read operator" in made
    assert "command admin" in shell.board("boards", "change", "lab", "--command", "admin")
    assert "lab\tLab\tread operator, post operator, command admin" in shell.board("boards", "list")
    with pytest.raises(BoardError, match="commanding is for operators"):
        shell.board("boards", "change", "lab", "--command", "member")
    changes = ["--owner", "ann", "--command", "risky=nobody", "--camera-days", "7", "--camera", "member"]
    said = shell.board("robot", "change", "quadruped", *changes, "--closed", "mon-fri 22:00-06:00 Europe/Berlin")
    assert said == shell.board("robot", "show", "quadruped")
    for words in ("owner: ann", "risky nobody", "move operator", "kept 7 days", "mon,tue,wed,thu,fri 22:00-06:00"):
        assert words in said
    assert "closed: never" in shell.board("robot", "change", "quadruped", "--closed", "")
    assert "/invite/" in shell.board("invite", "add", "--role", "operator", "--uses", "3", "--days", "2")
    invite = next(line for line in shell.board("invite", "list").splitlines() if "operator" in line)
    assert "3 left" in invite
    shell.board("invite", "revoke", invite.split("\t")[0])
    assert "operator" not in shell.board("invite", "list")
    assert "/invite/" in shell.board("invite", "add", "--simulated")
    assert "member, operator of simulated robots" in shell.board("invite", "list")
    assert "commands simulated robots" in shell.board("account", "change", "ann", "--role", "member", "--simulated")


def test_moderation_loses_nothing_and_is_in_the_audit_log(shell: Shell) -> None:
    topic, number = post(shell, "rude words")
    shell.board("moderate", "hide", number, "--reason", "rude")
    assert shell.board("moderate", "read", number).startswith("ann: rude words")
    shell.board("moderate", "show", number)
    shell.board("moderate", "lock", topic)
    shell.board("moderate", "lock", topic, "--unlock")
    shell.board("moderate", "move", topic, "robots", "--reason", "belongs there")
    log = shell.board("audit", "--limit", "5")
    told = [line.split()[2:5] for line in reversed(log.splitlines())]
    assert told == [
        ["shell", "post.hide", f"post:{number}"],
        ["shell", "post.show", f"post:{number}"],
        *[["shell", f"topic.{action}", f"topic:{topic}"] for action in ("lock", "unlock", "move")],
    ]
    assert "reason=rude" in log
    assert shell.board("audit", "--target", f"post:{number}").count("\n") == 2


@pytest.mark.parametrize("words", ["audit", "account list", "account tokens chief", "boards list", "invite list"])
def test_a_list_that_is_read_slowly_blocks_no_writes(shell: Shell, words: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full pipe blocks the command that prints; meanwhile the forum accepts posts and stops."""
    post(shell, "something to read")
    shell.board("invite", "add")
    shell.board("account", "token", "chief")
    impatient, printed = replace(shell.settings, busy_timeout_s=0.05), []

    def into_a_full_pipe(line: str) -> None:
        with local_admin.writing(impatient) as connection:
            writes.record(Transaction(connection), EventKind.ROBOT_STOP, "quadruped", None, None, 0)
        printed.append(line)

    monkeypatch.setattr(typer, "echo", into_a_full_pipe)
    shell.board(*words.split())
    assert printed


def test_a_backup_is_restored_into_an_empty_forum_and_an_export_has_no_secrets(shell: Shell, tmp_path: Path) -> None:
    _, number = post(shell, "to be kept")
    shell.board("boards", "add", "lab", "--name", "Lab", "--read", "operator", "--post", "operator")
    assert "accounts" in shell.board("backup", str(tmp_path / "forum.tar.gz"))
    assert shell.board("export", str(tmp_path / "words.tar.gz"), "--account", "ann").endswith(" posts\n")
    other = Shell(tmp_path)
    other.config.write_text(f'data = "{tmp_path / "data"}"\n')
    assert "posts" in other.board("restore", str(tmp_path / "forum.tar.gz"))
    assert "to be kept" in other.board("moderate", "read", number)
    with pytest.raises(BoardError, match="has accounts already"):
        other.board("restore", str(tmp_path / "forum.tar.gz"))
    with pytest.raises(BoardError, match="cannot keep a board to operators"):
        other.board("migrate", "--to", "0001")
    other.board("boards", "change", "lab", "--read", "member", "--post", "member")
    assert "0001" in other.board("migrate", "--to", "0001")
    assert "head" in other.board("migrate")


def test_erasing_is_announced_before_it_is_done(shell: Shell) -> None:
    shell.board("account", "add", "leaver")
    leaver = local_admin.find_account(shell.settings, "leaver")
    with local_admin.writing(shell.settings) as connection:
        draft = writes.Draft(leaver, Text("my words").rendered(()))
        made = writes.create_topic(Transaction(connection), "talk", "Mine", draft)
    with pytest.raises(AgentRobError, match="--yes"):
        shell.board("account", "erase", "leaver")
    assert "my words" in shell.board("moderate", "read", made.post.id)
    assert shell.board("account", "erase", "leaver", "--yes") == "1 posts and 0 pictures of leaver are deleted\n"
    assert "my words" not in shell.board("moderate", "read", made.post.id)
    chief = local_admin.find_account(shell.settings, "chief")
    with local_admin.writing(shell.settings) as connection, pytest.raises(BoardError, match="erased"):
        moderation.show(Transaction(connection), chief, made.post.id)
    assert shell.board("expire") == "0 pictures expired, 0 files deleted\n"


@pytest.mark.parametrize(
    "words", ["account list", "boards list", "invite list", "audit", "backup {}/x.tar", "account add late"]
)
def test_only_migrate_changes_the_tables_of_another_version(tmp_path: Path, words: str) -> None:
    """An older server may still be using them."""
    shell = Shell(tmp_path)
    shell.config.write_text(f'data = "{tmp_path / "data"}"\n[board]\nlisten = "127.0.0.1:0"\n')
    asked, path = words.format(tmp_path).split(), shell.settings.database_path
    assert path is not None
    if "late" not in asked:
        with pytest.raises(ConfigError, match=r"there is no forum in .* agentrob init"):
            shell.board(*asked)
        assert not path.exists(), "looking makes no database"
    local_admin.bootstrap(shell.settings)
    migrate(shell.settings, "0005_processes")
    with serving_lock(shell.settings):  # as an older server would hold it
        for _ in range(2):
            with pytest.raises(BoardError, match="are at 0005_processes, and this version of AgentRob needs") as caught:
                shell.board(*asked)
            assert caught.value.hint == "end the forum, then run: agentrob board migrate"
        with pytest.raises(BoardError, match="another process serves the forum"):
            migrate(shell.settings)
    with pytest.raises(BoardError, match="are at 0005_processes"):
        shell.board(*asked)
    shell.board("migrate")
    shell.board(*asked)


def test_listing_does_not_wait_for_writers_and_creates_nothing(shell: Shell, tmp_path: Path) -> None:
    _, made = post(shell, "some words")
    lists = [
        ["account", "list"], ["account", "tokens", "quadruped"], ["boards", "list"], ["robot", "show", "quadruped"],
        ["invite", "list"], ["audit"], ["moderate", "read", made],
    ]  # fmt: skip
    with local_admin.writing(shell.settings):  # holds the write lock, like a server that is writing
        for words in lists:
            shell.board(*words)
    missing = Shell(tmp_path / "none")
    missing.folder.mkdir()
    missing.config.write_text(f'data = "{missing.folder}/data"\n')
    for words in lists:
        with pytest.raises(ConfigError, match="there is no forum"):
            missing.board(*words)
    assert not (missing.folder / "data").exists()
