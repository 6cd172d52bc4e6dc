//! What each of iceoryx2's errors asks the start loop to do.

use iceoryx2::node::NodeCreationFailure;
use iceoryx2::port::listener::ListenerCreateError;
use iceoryx2::port::notifier::NotifierCreateError;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError, RequestResponseOpenError, RequestResponseOpenOrCreateError,
};
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;

/// What to do about an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The topic is not there yet.
    Absent,
    /// Somebody is coming or going: try again soon.
    Again,
    /// Somebody removes it: try again soon. When that lasts he has died: mend.
    Leaving,
    /// Left half made, perhaps by the dead: look, mend and try again.
    Heal,
    /// No place is free: make the dead give theirs back and try again.
    Crowded,
    /// Made with other settings by others.
    Different,
    /// Nothing that waiting mends.
    Hopeless,
}

/// An error with a verdict.
pub(crate) trait Judge: std::fmt::Debug {
    fn verdict(&self) -> Verdict;
}

impl Judge for NodeCreationFailure {
    fn verdict(&self) -> Verdict {
        match self {
            Self::InsufficientPermissions => Verdict::Hopeless,
            Self::InternalError | Self::SystemCorrupted | Self::UnableToGenerateUniqueNodeId => {
                Verdict::Again
            }
        }
    }
}

impl Judge for PublishSubscribeOpenError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::DoesNotExist => Verdict::Absent,
            Self::HangsInCreation | Self::ServiceInCorruptedState => Verdict::Heal,
            Self::ExceedsMaxNumberOfNodes => Verdict::Crowded,
            Self::InsufficientPermissions
            | Self::UnableToAcquireTypeDefinition
            | Self::InvalidTypeDefinition => Verdict::Hopeless,
            Self::IncompatibleTypes
            | Self::IncompatibleMessagingPattern
            | Self::IncompatibleAttributes
            | Self::IncompatibleOverflowBehavior
            | Self::VersionMismatch
            | Self::DoesNotSupportRequestedMinBufferSize
            | Self::DoesNotSupportRequestedMinHistorySize
            | Self::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | Self::DoesNotSupportRequestedAmountOfPublishers
            | Self::DoesNotSupportRequestedAmountOfSubscribers
            | Self::DoesNotSupportRequestedAmountOfNodes => Verdict::Different,
            Self::IsMarkedForDestruction => Verdict::Leaving,
            Self::Interrupt | Self::InternalFailure | Self::UnableToCreateServiceTag => Verdict::Again,
        }
    }
}

impl Judge for PublishSubscribeCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::HangsInCreation | Self::ServiceInCorruptedState => Verdict::Heal,
            Self::InsufficientPermissions
            | Self::SubscriberBufferMustBeLargerThanHistorySize
            | Self::UnableToAcquireTypeDefinition
            | Self::InvalidTypeDefinition => Verdict::Hopeless,
            Self::Interrupt
            | Self::AlreadyExists
            | Self::InternalFailure
            | Self::IsBeingCreatedByAnotherInstance
            | Self::UnableToCreateServiceTag
            | Self::ServiceConfigCouldNotBeCreated
            | Self::UnableToGenerateUniqueServiceId => Verdict::Again,
        }
    }
}

impl Judge for PublishSubscribeOpenOrCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::PublishSubscribeOpenError(error) => error.verdict(),
            Self::PublishSubscribeCreateError(error) => error.verdict(),
            Self::SystemInFlux => Verdict::Again,
        }
    }
}

impl Judge for EventOpenError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::DoesNotExist => Verdict::Absent,
            Self::HangsInCreation | Self::ServiceInCorruptedState => Verdict::Heal,
            Self::ExceedsMaxNumberOfNodes => Verdict::Crowded,
            Self::InsufficientPermissions => Verdict::Hopeless,
            Self::IncompatibleMessagingPattern
            | Self::IncompatibleAttributes
            | Self::IncompatibleDeadline
            | Self::IncompatibleNotifierCreatedEvent
            | Self::IncompatibleNotifierDroppedEvent
            | Self::IncompatibleNotifierDeadEvent
            | Self::VersionMismatch
            | Self::DoesNotSupportRequestedAmountOfNotifiers
            | Self::DoesNotSupportRequestedAmountOfListeners
            | Self::DoesNotSupportRequestedMaxEventId
            | Self::DoesNotSupportRequestedAmountOfNodes => Verdict::Different,
            Self::IsMarkedForDestruction => Verdict::Leaving,
            Self::Interrupt | Self::InternalFailure | Self::UnableToCreateServiceTag => Verdict::Again,
        }
    }
}

impl Judge for EventCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ServiceInCorruptedState => Verdict::Heal,
            Self::InsufficientPermissions | Self::EventIdExceedsMaxSupportedValue => Verdict::Hopeless,
            Self::Interrupt
            | Self::InternalFailure
            | Self::IsBeingCreatedByAnotherInstance
            | Self::AlreadyExists
            | Self::UnableToCreateServiceTag
            | Self::ServiceConfigCouldNotBeCreated
            | Self::UnableToGenerateUniqueServiceId => Verdict::Again,
        }
    }
}

impl Judge for EventOpenOrCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::EventOpenError(error) => error.verdict(),
            Self::EventCreateError(error) => error.verdict(),
            Self::SystemInFlux => Verdict::Again,
        }
    }
}

impl Judge for PublisherCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedPublishers => Verdict::Crowded,
            _ => Verdict::Again,
        }
    }
}

impl Judge for SubscriberCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedSubscribers => Verdict::Crowded,
            Self::BufferSizeExceedsMaxSupportedBufferSizeOfService
            | Self::HistoryRequestExceedsHistorySizeOfService
            | Self::HistoryRequestExceedsBufferSizeOfSubscriber => Verdict::Different,
            _ => Verdict::Again,
        }
    }
}

impl Judge for ListenerCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedListeners => Verdict::Crowded,
            _ => Verdict::Again,
        }
    }
}

impl Judge for NotifierCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedNotifiers => Verdict::Crowded,
            _ => Verdict::Again,
        }
    }
}

impl Judge for RequestResponseOpenError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::DoesNotExist => Verdict::Absent,
            Self::HangsInCreation | Self::ServiceInCorruptedState => Verdict::Heal,
            Self::ExceedsMaxNumberOfNodes => Verdict::Crowded,
            Self::InsufficientPermissions
            | Self::UnableToAcquireTypeDefinition
            | Self::InvalidTypeDefinition => Verdict::Hopeless,
            Self::DoesNotSupportRequestedAmountOfClientRequestLoans
            | Self::DoesNotSupportRequestedAmountOfActiveRequestsPerClient
            | Self::DoesNotSupportRequestedResponseBufferSize
            | Self::DoesNotSupportRequestedAmountOfServers
            | Self::DoesNotSupportRequestedAmountOfClients
            | Self::DoesNotSupportRequestedAmountOfNodes
            | Self::DoesNotSupportRequestedAmountOfBorrowedResponsesPerPendingResponse
            | Self::IncompatibleRequestOrResponseType
            | Self::IncompatibleAttributes
            | Self::IncompatibleMessagingPattern
            | Self::IncompatibleOverflowBehaviorForRequests
            | Self::IncompatibleOverflowBehaviorForResponses
            | Self::IncompatibleBehaviorForFireAndForgetRequests
            | Self::VersionMismatch => Verdict::Different,
            Self::IsMarkedForDestruction => Verdict::Leaving,
            Self::Interrupt | Self::InternalFailure | Self::UnableToCreateServiceTag => Verdict::Again,
        }
    }
}

impl Judge for RequestResponseCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::HangsInCreation | Self::ServiceInCorruptedState => Verdict::Heal,
            Self::InsufficientPermissions
            | Self::UnableToAcquireTypeDefinition
            | Self::InvalidTypeDefinition => Verdict::Hopeless,
            Self::Interrupt
            | Self::AlreadyExists
            | Self::InternalFailure
            | Self::IsBeingCreatedByAnotherInstance
            | Self::UnableToCreateServiceTag
            | Self::ServiceConfigCouldNotBeCreated
            | Self::UnableToGenerateUniqueServiceId => Verdict::Again,
        }
    }
}

impl Judge for RequestResponseOpenOrCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::RequestResponseOpenError(error) => error.verdict(),
            Self::RequestResponseCreateError(error) => error.verdict(),
            Self::SystemInFlux => Verdict::Again,
        }
    }
}

impl Judge for ServerCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedServers => Verdict::Crowded,
            _ => Verdict::Again,
        }
    }
}

impl Judge for ClientCreateError {
    fn verdict(&self) -> Verdict {
        match self {
            Self::ExceedsMaxSupportedClients => Verdict::Crowded,
            Self::MaxActiveRequestsExceedsMaxSupportedActiveRequestsOfService => Verdict::Different,
            _ => Verdict::Again,
        }
    }
}
