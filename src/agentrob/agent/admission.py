"""Admit commands within the rate limits of their accounts."""

from __future__ import annotations

from dataclasses import dataclass

from agentrob.agent.intake.rate_limit import RateLimiter
from agentrob.agent.progress import show
from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.config.robots import RatesConfig
from agentrob.language.messages.catalog import say
from agentrob.model import Command, CommandState, Decision, Verdict


@dataclass(frozen=True)
class Admission:
    """The rate limits of one robot: commands that wait, commands an hour, and a cooldown."""

    rates: RatesConfig
    queue: CommandQueue
    limiter: RateLimiter

    def over_limit(self, command: Command) -> bool:
        """Whether a command that its account posts now would be refused. Counts nothing."""
        account, most = command.author.id, self.rates.waiting
        return self.limiter.exceeded(account) or bool(most and self.queue.number_of(account) > most)

    async def admit(self, job: QueuedCommand) -> Verdict | None:
        """Wait until the account is within its rate limit; return a refusal if that takes long."""
        author, language = job.command.author, job.command.language
        most = self.rates.waiting
        if most and len(self.queue.of_same_author(job)) >= most:
            return Verdict(Decision.REFUSE, "rate.waiting", say("agent.rate.waiting", language, count=most))
        await self.queue.in_order(job)
        while job.ended is None and (wait := self.limiter.take(author.id)) is not None:
            if not wait.short:
                count = self.rates.commands_per_hour
                reason = say(f"agent.{wait.rule}", language, minutes=wait.minutes, count=count)
                return Verdict(Decision.REFUSE, wait.rule, reason)
            show(job, say("agent.held", language, seconds=wait.seconds), CommandState.QUEUED)
            await self.queue.hold(job, wait.seconds)
        self.queue.mark_admitted(job)
        return None
