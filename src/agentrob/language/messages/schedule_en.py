"""What robots say in English about schedules."""

SCHEDULE = {
    "schedule.unclear": "I did not understand when. I have not scheduled anything and did not move.",
    "schedule.what": "I understood when, but not what to do. I have not scheduled anything.",
    "schedule.hour": "I understood the day, but not the time. I have not scheduled anything.",
    "schedule.day": 'On which day is {hour} meant? I have not scheduled anything; say for example "today at {hour}" or '
    '"every day at {hour}".',
    "schedule.half": "Is {early} or {late} meant? I have not scheduled anything; please write a time from 00:00 to "
    "23:59, or am or pm.",
    "schedule.midnight": "Is the midnight at the beginning or at the end of that day meant? I have not scheduled "
    "anything; please write 00:00 or 23:59 of a day.",
    "schedule.past": "{time} is over already. I have not scheduled anything; please name the day.",
    "schedule.none": "Nothing would ever run at these times. I have not scheduled anything.",
    "schedule.far": "That is more than {days} days ahead, the most that I schedule.",
    "schedule.often": "Runs must be at least {minutes} minutes apart. I have not scheduled anything.",
    "schedule.runs": "One schedule has 1 to {count} runs. I have not scheduled anything.",
    "schedule.between": "Between which times is that meant? I have not scheduled anything.",
    "schedule.examples": "Put the time at the beginning, for example `in 10 minutes wave` · `tomorrow at 9:00 wave` · "
    "`every weekday at 9:00 take a photo` · `every 15 minutes between 9:00 and 17:00 take a photo`.",
    "read.later": "{line} At the times that my reply will name.",
    "drive.later": "This says when to move, and `agentrob drive` moves only now. Leave out the time, or post it on the "
    "robot's forum, where it becomes a schedule.",
    "schedule.made": "Scheduled: {understood}.",
    "schedule.next.once": "It runs on {times} ({zone}).",
    "schedule.next": "The next runs are {times} ({zone}).",
    "schedule.ends.both": "It ends after {runs} runs, at the latest on {until}, unless you then reply `keep on`.",
    "schedule.ends.runs": "It ends after {runs} runs.",
    "schedule.ends.until": "It ends on {until}, or after {runs} runs unless you then reply `keep on`.",
    "schedule.renewed": "Renewed: {understood}.",
    "schedule.renew.others": "Only {who} can renew this schedule. You can post one of your own.",
    "schedule.renew.running": "There is nothing to renew: the schedule goes on.",
    "schedule.renew.late": "I read this too late to renew the schedule. Please reply `keep on` again.",
    "schedule.renew.rights": "I have not renewed this schedule, because you may not command me any more.",
    "schedule.renew.full": "I have not renewed this schedule: you would have more than {count} schedules of this "
    "robot, the most for one account. Cancel one and reply `keep on` again.",
    "schedule.approval": "Each run needs an approval when it is due.",
    "schedule.how": "Each run is checked and answered like a new command. To cancel, reply `cancel` here, or edit or "
    "delete your post. A stop of this robot ends its schedules, too.",
    "schedule.full": "you have {count} schedules of this robot already, the most for one account; cancel one first",
    "schedule.times.joint": ", ",
    "schedule.list": "{count} schedules:",
    "schedule.list.one": "1 schedule:",
    "schedule.list.none": "I have no schedules.",
    "schedule.list.item": "{understood}: next {at} ({zone}), {runs} runs left, posted by {who}",
    "schedule.run": "Run {number} of {of} of {schedule}, due on {at} ({zone}).",
    "schedule.run.limited": "Run {number} of at most {of} of {schedule}, due on {at} ({zone}).",
    "schedule.run.once": "Run of {schedule}, due on {at} ({zone}).",
    "schedule.run.schedule": "this schedule",
    "schedule.ended.limit": "This schedule ends with this run: it had as many runs or days as any schedule may have. "
    "Its author can reply `keep on` here to renew it.",
    "schedule.ended.stop": "This schedule has ended because I was stopped or released after it was posted. Post it "
    "again to continue.",
    "schedule.ended.cancelled": "This schedule is cancelled. There will be no further runs.",
    "schedule.ended.edited": "This schedule has ended because its post was edited. Post it again to continue.",
    "schedule.ended.rights": "This schedule has ended because its author may not command me any more.",
    "agent.missed": "I did not run at {at} ({zone}): I was not able to begin within {late} of that time. I do not make "
    "up for it.",
    "agent.missed.more": "I did not run at {at} ({zone}) and the {count} times after it: I was not able to begin "
    "within {late} of those times. I do not make up for them.",
    "agent.because.overlap": "the run before it had not ended",
}
