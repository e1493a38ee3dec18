"""The exceptions of rali. Their text is the sentence that the command line prints."""


class Error(Exception):
    """Base of what rali raises: where, problem and remedy are the parts of the sentence."""

    def __init__(self, sentence, where="", problem="", remedy=""):
        super().__init__(sentence)
        self.where = where
        self.problem = problem
        self.remedy = remedy


class InputError(Error):
    """Unreadable, damaged or unfit input."""


class SettingsError(InputError):
    """Settings or arguments that are unknown or not allowed."""


class NoAnswerError(Error):
    """Nothing is wrong, but the question has no answer here."""


class MachineError(Error):
    """Disk full, no permission, no memory."""
